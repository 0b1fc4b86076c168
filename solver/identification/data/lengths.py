"""Lengths as people type them, readings of one, and the distance between a placement's sockets."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple, cast

import numpy as np

from ....recorder import DEFAULT_DISTANCE, Placement
from .measurements import MeasurementError

Readings = float | Sequence[float] | np.ndarray
"""One reading of a length, or several [m]."""
AGREEING = 1.2e-4
"""Two readings of a caliper that are no farther apart are of one length [m]."""
_SHORTEST_BASE, _LONGEST_BASE = 5e-3, 1.0
"""Balls have a diameter, and arms a reach [m]."""
_UNITS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}


def millimetres(text: str) -> float:
    """Return a typed length, such as ``0.1``, ``0.1mm`` or ``100um`` [mm]."""
    return metres(text, 1e-3) / 1e-3


def metres(text: str, unit: float = 1.0) -> float:
    """Return a typed length, such as ``0.1001`` or ``100.1mm`` [m]; ValueError for no length.

    ``unit`` is that of a number without one [m].
    """
    word = text.strip()
    for name, factor in _UNITS.items():
        if word.endswith(name):
            return factor * float(word[: -len(name)])
    return unit * float(word)


def readings_of(distance: Readings | None) -> tuple[float, ...]:
    """Return readings as a tuple; none where nobody read anything."""
    if distance is None:
        return ()
    if isinstance(distance, np.ndarray):
        return tuple(np.ravel(distance).tolist())
    if isinstance(distance, Sequence) and not isinstance(distance, str):
        return tuple(distance)
    return (cast("float", distance),)


def agreed_length(readings: Sequence[float]) -> float:
    """Return the mean of the two readings that are nearest to each other, or the last one [m].

    The last one stands where no two agree.
    """
    pairs = pairwise(sorted(readings))
    a, b = min(pairs, key=lambda pair: pair[1] - pair[0], default=(0.0, 1.0))
    if b - a > AGREEING:
        return readings[-1]
    return round((a + b) / 2, 7)


def agreeing(length: float, readings: Sequence[float]) -> int:
    """Return how many readings agree with a length [m]."""
    return sum(abs(reading - length) <= AGREEING for reading in readings)


class StatedLength(NamedTuple):
    """A distance between two sockets, and what it rests on."""

    distance: float
    """[m]."""
    source: str
    """``given`` by the user, the ``recording``, or nothing but the ``default``."""
    readings: int
    """Number of readings that agree on it."""


def stated_length(
    placement: Placement,
    distance: Readings | None,
    warnings: list[str],
) -> StatedLength:
    """Return the distance of a placement's sockets; one given counts more than one recorded."""
    recorded = None if placement.distance_assumed else placement.distance
    typed = [check_distance(reading) for reading in readings_of(distance)]
    readings = typed.copy()
    if recorded is not None:
        readings += [d for d in placement.readings or (recorded,) if d not in typed]
    if typed:
        source = "given"
        length = agreed_length(typed)
        if recorded not in (None, length):
            warnings.append(
                f"{placement.name}: distance {length:.7g} m as given, not the recording's "
                f"{placement.distance} m"
            )
    elif recorded is not None:
        source = "recording"
        length = check_distance(recorded, f"{placement.where}: ")
    else:
        source = "default"
        length = check_distance(placement.distance or DEFAULT_DISTANCE)
    return StatedLength(length, source, agreeing(length, readings))


def check_distance(distance: float, where: str = "") -> float:
    """Return a distance between sockets if it is possible [m]; messages begin with ``where``."""
    try:
        length = float(distance)
    except (TypeError, ValueError):
        length = math.inf
    if not length > 0:
        raise MeasurementError(
            f"{where}distance {distance}: the distance between the sockets' centres is a positive "
            "number of metres, for example 0.05"
        )
    if not _SHORTEST_BASE <= length <= _LONGEST_BASE:
        advice = ", for example 0.05"
        if _SHORTEST_BASE <= length / 1e3 <= _LONGEST_BASE:
            advice = f"; did you mean {length / 1e3:g}?"
        raise MeasurementError(
            f"{where}distance {distance!r}: metres are expected{advice}"
        )
    return length
