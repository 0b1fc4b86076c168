"""Check of the distances between sockets, against the size of the arm's model.

Recordings of a ball do not tell how large an arm is: the sockets' distance does. So a wrong
distance makes a wrong arm, and fits as well as the right one. But a link is machined to better
than 0.1 %: an arm that comes out longer by more has most likely a wrong distance.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..data import (
    CALIPER_DEVIATION,
    Known,
    KnownDistance,
    Measurement,
    distance_covariance,
    find_socket,
)
from .diagnostic import Diagnostic, where_of
from .robust_fit import RigidFit

SUSPECT, WRONG = 0.003, 0.01
"""Shares by which an arm's size may differ from its model's: more than the first is doubtful, more
than the second is a mistake."""
ARMS = 0.002
"""Standard deviation of the scale of real arms about their models."""
DEVIATIONS = 3
CORRELATED = 3
"""Variance of a mean of samples, relative to that of independent ones: the errors of a sample and
the next are correlated by about a half."""
ODD = 0.03
"""A placement whose distance differs from the others' by this share is wrong for a reason of its
own. Where the distance was measured anew, the smaller share WRONG is enough."""
SAME_DISTANCE = 2e-5
"""Distances that differ by less are of one base, measured again [m]."""
SAME_PLACE = 0.2
"""Sockets nearer to each other than this part of their distance are one socket,"""
ONE_PLACE = 0.02
"""unless they are farther apart than this [m], about the size of a ball."""
_SOURCES = {
    "default": "nothing but the default: measure it, and give --distance",
    "given": "as given: measure it again, and mend --distance",
    "located": "by the sockets' coordinates: measure those again",
    "recording": "as placement.json has it: measure it again, and mend it there, or --distance",
}


@dataclass(frozen=True)
class Scale:
    """The size of an arm by measured distances, before any fit believes them."""

    value: float
    """Relative excess of the arm's size over its model's, 0.02 for 2 %."""
    deviation: float


def size_level(
    value: float, deviation: float | None
) -> Literal["error", "unknown", "warning"] | None:
    """Return how doubtful an arm's size is, that came out so much larger; None for not at all.

    Arms scatter by 0.2 %. One that is off by more than three standard deviations of that and of
    what is known of it, which is 0.6 % with a caliper's distance, has most likely a wrong distance.
    An arm of servos whose gears have play may be off by more than any arm is, and be known so badly
    that this says nothing.

    Args:
        value: By how much it is larger, 0.02 for 2 %.
        deviation: Standard deviation of that; None where the method does not say.
    """
    size, known = abs(value), deviation or 0.0
    allowed = DEVIATIONS * math.hypot(known, ARMS)
    if size > min(WRONG, allowed):
        return "error" if size > allowed else "unknown"
    return "warning" if size > max(SUSPECT, DEVIATIONS * known) else None


@dataclass(frozen=True)
class DistanceVerdict:
    """Errors of known distances, and the size of the arm by those that are right."""

    shared: tuple[Diagnostic, ...]
    """Diagnostics of all placements, or of a distance between two of them."""
    single: dict[str, Diagnostic]
    """Diagnostics of single placements, by name."""
    scale: Scale | None
    """None where no distance is known, or all are wrong."""

    @property
    def doubts_scale(self) -> bool:
        """True where the arm's size is not believable."""
        return any(diagnostic.code == "scale" for diagnostic in self.shared)


@dataclass(frozen=True)
class _Ratios:
    """Logarithms of known distances over those that the model expects, one a distance."""

    expected: np.ndarray
    """[m]."""
    logarithms: np.ndarray
    covariance: np.ndarray
    own: np.ndarray
    """Deviations without what distances of one base share."""

    def scale(self, kept: np.ndarray) -> Scale:
        """Return the scale that some of the distances agree on best."""
        precision = np.linalg.inv(self.covariance[np.ix_(kept, kept)])
        total = float(precision.sum())
        mean = float(precision.sum(axis=0) @ self.logarithms[kept]) / total
        left = self.logarithms[kept] - mean
        freedom = max(len(left) - 1, 1)
        scatter = max(float(left @ precision @ left) / freedom, 1.0)  # they may disagree by more
        return Scale(float(np.expm1(mean)), (scatter / total) ** 0.5)


def check_distances(
    measurements: Sequence[Measurement],
    fit: RigidFit,
    moved: Collection[str] = (),
    known: Sequence[KnownDistance] = (),
    deviation: float = CALIPER_DEVIATION,
) -> DistanceVerdict:
    """Compare the distances that are known with the model's.

    Args:
        measurements: The placements.
        fit: To all of them, one socket after the other.
        moved: Names of those whose base moved, so that their sockets are not its own distance
            apart.
        known: Distances measured beside those between each placement's sockets, see :func:`named`.
        deviation: Standard deviation of the latter [m].
    """
    bases = [m for m in measurements if m.has_distance and m.name not in moved]
    usable = [k for k in known if not {k.first[0], k.second[0]} & set(moved)]
    rulers = _rulers(_labels(measurements), bases, usable, deviation)
    if not rulers:
        return DistanceVerdict((), {}, None)
    ratios, n = _ratios(rulers, fit), len(bases)
    anew = _measured_anew(bases)
    limits = np.array([WRONG if own else ODD for own in anew] + [ODD] * len(usable))
    odd, lengths = _odd(ratios, limits), ratios.expected.tolist()
    least = [min(SAME_PLACE * m.distance, ONE_PLACE) for m in bases]
    one = [length < limit for limit, length in zip(least, lengths, strict=False)]
    single = {
        m.name: _one_socket(m, lengths[i]) if one[i] else _other_distance(m, lengths[i], anew[i])
        for i, m in enumerate(bases)
        if one[i] or odd[i]
    }
    wrong = [_wrong_known(k, lengths[n + i]) for i, k in enumerate(usable) if odd[n + i]]
    kept = ~odd
    kept[:n] &= ~np.array(one, dtype=bool)
    if not kept.any():
        return DistanceVerdict(tuple(wrong), single, None)
    scale = ratios.scale(kept)
    judged = [m for m in bases if m.name not in single]
    return DistanceVerdict((*wrong, *_scale_diagnostics(judged, scale)), single, scale)


def _rulers(
    labels: Sequence[tuple[str, int]],
    bases: Sequence[Measurement],
    known: Sequence[KnownDistance],
    deviation: float,
) -> list[Known[int]]:
    """Return the distances of bases, then those known beside them, by the sockets' indices."""
    rulers: list[Known[int]] = []
    for m in bases:
        a, b = (labels.index((m.name, socket)) for socket in m.sockets[:2])
        rulers.append(Known(a, b, m.distance, deviation, on_base=True))
    for k in known:
        a, b = (labels.index(end) for end in (k.first, k.second))
        rulers.append(Known(a, b, k.distance, k.deviation))
    return rulers


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


def _ratios(rulers: Sequence[Known[int]], fit: RigidFit) -> _Ratios:
    first, second = (np.array([r.first for r in rulers]), np.array([r.second for r in rulers]))
    offsets = fit.centres[second] - fit.centres[first]
    expected = np.linalg.norm(offsets, axis=1).clip(1e-12)
    directions = offsets / expected[:, None]
    slopes = np.einsum("ki,kij->kj", directions, fit.jacobian[second] - fit.jacobian[first])
    slopes /= expected[:, None]
    distances = np.array([r.distance for r in rulers])
    scatter = (fit.spread[first] + fit.spread[second]) / expected**2
    by_fit = CORRELATED * (slopes @ fit.covariance @ slopes.T + np.diag(scatter))
    measured = distance_covariance(rulers) / np.outer(distances, distances)
    shared = [r.on_base * (r.deviation / r.distance) ** 2 for r in rulers]
    covariance = by_fit + measured
    own = np.sqrt(np.diag(covariance) - shared)
    return _Ratios(expected, np.log(distances / expected), covariance, own)


def _measured_anew(bases: Sequence[Measurement]) -> list[bool]:
    """Return a mask of bases whose distance is another than most's."""
    distances = np.array([m.distance for m in bases])
    return (np.abs(distances - np.median(distances)) > SAME_DISTANCE).tolist() if bases else []


def _odd(ratios: _Ratios, limits: np.ndarray) -> np.ndarray:
    """Return a mask of distances that contradict the others by more than each may.

    Of two, it is the one that is not nearly what the model says; of one, nothing can be said.
    """
    logarithms = ratios.logarithms
    away = np.abs(logarithms)
    if len(logarithms) < 3 and not (away < limits).any():
        return np.zeros(len(logarithms), dtype=bool)
    if len(logarithms) > 2:
        away = np.abs(logarithms - np.median(logarithms))
    return away > np.maximum(limits, 5 * ratios.own)


def _wrong_known(known: KnownDistance, length: float) -> Diagnostic:
    return Diagnostic(
        "error",
        "known",
        f"--known {known}",
        f"these sockets are {1e3 * length:.1f} mm apart by the model",
        "measure it again, or give the sockets that were meant",
    )


def _one_socket(measured: Measurement, length: float) -> Diagnostic:
    first, second = measured.sockets[:2]
    return Diagnostic(
        "error",
        "one-socket",
        where_of([measured]),
        f"sockets {first} and {second} lie at the same place, {1e3 * length:.1f} mm apart, not "
        f"{1e3 * measured.distance:.1f}",
        "all was recorded with the ball in one socket: record the other",
    )


def _other_distance(measured: Measurement, length: float, anew: bool) -> Diagnostic:
    by, rest = (" and the other recordings", "") if anew else ("", " as in the others")
    return Diagnostic(
        "error",
        "distance",
        where_of([measured]),
        f"its sockets are {1e3 * length:.1f} mm apart by the model{by}, not "
        f"{1e3 * measured.distance:.1f}{rest}",
        f"that distance is {_SOURCES[measured.distance_source]}"
        if anew
        else "the base moved between its sockets, or a file is another placement's: record it "
        "again",
    )


def _scale_diagnostics(judged: Sequence[Measurement], scale: Scale) -> list[Diagnostic]:
    """Return an arm's size that is not believable; nothing without a base, whose distance it is."""
    level = size_level(scale.value, scale.deviation)
    if not judged or level is None or abs(np.log1p(scale.value)) < DEVIATIONS * scale.deviation:
        return []
    given = judged[0].distance
    likely = given / (1 + scale.value)
    longer = "longer" if scale.value > 0 else "shorter"
    text = (
        f"the arm comes out {100 * abs(scale.value):.1f} % {longer} than its model (+- "
        f"{100 * scale.deviation:.2f} %); more likely the sockets are {1e3 * likely:.1f} mm apart "
        f"than {1e3 * given:.1f}"
    )
    advice = f"that distance is {_SOURCES[judged[0].distance_source]}"
    level = "error" if level == "error" else "warning"
    return [Diagnostic(level, "scale", where_of(judged), text, advice)]
