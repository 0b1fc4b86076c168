"""Known distances between sockets, and the size of an arm by them.

Recordings of a ball do not tell how large an arm is: the sockets' distance does. But a link is
machined to better than 0.1 %: an arm that comes out longer by more most likely has a wrong
distance.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from ..data import Known, KnownDistance, Measurement, find_socket
from .hypotheses import ARMS

SUSPECT, WRONG = 0.003, 0.01
"""Shares by which an arm's size may differ from its model's: more than the first is doubtful, more
than the second is a mistake."""
DEVIATIONS = 3


@dataclass(frozen=True)
class Scale:
    """The size of an arm by measured distances, before any fit believes them."""

    value: float
    """Relative excess of the arm's size over its model's, 0.02 for 2 %."""
    deviation: float


def size_level(
    value: float, deviation: float | None
) -> Literal["error", "unknown", "warning"] | None:
    """Return how doubtful an arm's size is; None for not at all.

    It came out larger by a share ``value``, of some standard deviation where the method says it.
    Arms scatter by 0.2 %. One that is off by more than three standard deviations of that and of
    what is known of it, which is 0.6 % with a caliper's distance, has most likely a wrong distance.
    An arm of servos whose gears have play may be off by more than any arm is, and be known so badly
    that this says nothing.
    """
    size, known = abs(value), deviation or 0.0
    allowed = DEVIATIONS * math.hypot(known, ARMS)
    if size > min(WRONG, allowed):
        return "error" if size > allowed else "unknown"
    return "warning" if size > max(SUSPECT, DEVIATIONS * known) else None


def rulers(
    measurements: Sequence[Measurement], known: Sequence[KnownDistance], deviation: float
) -> tuple[Known[int], ...]:
    """Return the distances of bases, then those known beside them, by the sockets' indices."""
    labels, found = _labels(measurements), list[Known[int]]()
    for m in measurements:
        if m.has_distance:
            a, b = (labels.index((m.name, socket)) for socket in m.sockets[:2])
            found.append(Known(a, b, m.distance, deviation, on_base=True))
    for k in known:
        a, b = (labels.index(end) for end in (k.first, k.second))
        found.append(Known(a, b, k.distance, k.deviation))
    return tuple(found)


def named(
    measurements: Sequence[Measurement], known: Sequence[KnownDistance]
) -> list[KnownDistance]:
    """Return known distances with the whole names of their placements.

    Raises:
        KnownError: One names a socket that is not there.
    """
    labels = _labels(measurements)

    def whole(end: tuple[str, int]) -> tuple[str, int]:
        return labels[find_socket(labels, end)]

    return [replace(k, first=whole(k.first), second=whole(k.second)) for k in known]


def _labels(measurements: Sequence[Measurement]) -> list[tuple[str, int]]:
    return [(m.name, socket) for m in measurements for socket in m.sockets]
