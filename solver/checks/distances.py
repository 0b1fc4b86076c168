"""The distance between the sockets, against what the arm's model says of it.

Recordings of a ball do not tell how large an arm is: the sockets' distance does. So a wrong
distance makes a wrong arm, and fits as well as the right one. But a link is machined to better
than 0.1 %: an arm that comes out longer by more has most likely a wrong distance.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from ..data.measurements import Measurement
from ..data.metrics import CALIPER_DEVIATION
from ..data.observations import SEAT_DEVIATION
from .finding import Finding, where_of
from .rigid import RigidFit

__all__ = ["Scale", "distance_findings", "scale_of"]

SUSPECT, WRONG = 0.003, 0.01
"""Change of an arm's scale that no arm should have, and that none has."""
DEVIATIONS = 3
CORRELATED = 3
"""Errors of a sample and the next are correlated by about a half: so much larger is the variance
of their means."""
ODD = 0.03
"""A placement whose distance differs by this part from the others' has a reason of its own."""
SAME_PLACE = 0.2
"""Sockets nearer to each other than this part of their distance are one socket."""
_SOURCES = {
    "default": "nothing but the default: measure it, and give --distance",
    "given": "as given: measure it again, and mend --distance",
    "located": "by the sockets' coordinates: measure those again",
    "recording": "as placement.json has it: measure it again, and mend it there, or --distance",
}


@dataclass(frozen=True)
class Scale:
    """What measured distances say of an arm's size, before any fit believes them."""

    value: float
    """By how much the arm is larger than its model, 0.02 for 2 %."""
    deviation: float


@dataclass(frozen=True)
class _Ratios:
    """Logarithms of measured distances over those that the model expects, one a placement."""

    expected: np.ndarray
    """[m]."""
    logarithms: np.ndarray
    covariance: np.ndarray
    own: np.ndarray
    """Deviations without what all placements share."""

    def scale(self, kept: np.ndarray) -> Scale:
        """Return the scale that some of the placements agree on best."""
        precision = np.linalg.inv(self.covariance[np.ix_(kept, kept)])
        total = float(precision.sum())
        mean = float(precision.sum(axis=0) @ self.logarithms[kept]) / total
        left = self.logarithms[kept] - mean
        freedom = max(len(left) - 1, 1)
        scatter = max(float(left @ precision @ left) / freedom, 1.0)  # they may disagree by more
        return Scale(float(np.expm1(mean)), (scatter / total) ** 0.5)


def scale_of(
    measurements: Sequence[Measurement], fit: RigidFit, moved: Collection[str] = ()
) -> Scale | None:
    """Return the scale of an arm by its recordings; None where no distance is known.

    Args:
        measurements: The placements.
        fit: To all of them, one socket after the other.
        moved: Names of those whose base moved, so that their sockets are not its own distance
            apart.
    """
    known, firsts = _known(measurements, moved)
    if not known:
        return None
    ratios = _ratios(known, fit, firsts)
    return ratios.scale(~_odd(ratios))


def distance_findings(
    measurements: Sequence[Measurement], fit: RigidFit, moved: Collection[str] = ()
) -> tuple[list[Finding], dict[str, Finding]]:
    """Return what is wrong with the distances of all placements, and of single ones, by name.

    Args:
        measurements: The placements.
        fit: To all of them, one socket after the other.
        moved: Names of those whose base moved.
    """
    known, firsts = _known(measurements, moved)
    if not known:
        return [], {}
    ratios = _ratios(known, fit, firsts)
    single = {
        m.name: _one_socket(m, length)
        for m, length in zip(known, ratios.expected.tolist(), strict=True)
        if length < SAME_PLACE * m.distance
    }
    odd = _odd(ratios)
    for i in np.flatnonzero(odd).tolist():
        single.setdefault(known[i].name, _other_distance(known[i], float(ratios.expected[i])))
    kept = np.array([m.name not in single for m in known])
    if not kept.any():
        return [], single
    scale = ratios.scale(kept)
    judged = [m for m, keep in zip(known, kept.tolist(), strict=True) if keep]
    return _scale_findings(judged, scale), single


def _known(
    measurements: Sequence[Measurement], moved: Collection[str]
) -> tuple[list[Measurement], list[int]]:
    """Return the placements whose distance is known, and the index of each one's first socket."""
    begins = np.cumsum([0, *(len(m.sockets) for m in measurements)]).tolist()
    kept = [i for i, m in enumerate(measurements) if m.has_distance and m.name not in moved]
    return [measurements[i] for i in kept], [begins[i] for i in kept]


def _ratios(known: Sequence[Measurement], fit: RigidFit, firsts: Sequence[int]) -> _Ratios:
    rows = np.array(firsts)
    offsets = fit.centres[rows + 1] - fit.centres[rows]
    expected = np.linalg.norm(offsets, axis=1)
    directions = offsets / expected[:, None].clip(1e-12)
    slopes = np.einsum("ki,kij->kj", directions, fit.jacobian[rows + 1] - fit.jacobian[rows])
    slopes /= expected[:, None]
    distances = np.array([m.distance for m in known])
    scatter = (fit.spread[rows] + fit.spread[rows + 1]) / expected**2
    seat = (SEAT_DEVIATION / distances) ** 2
    covariance = CORRELATED * (slopes @ fit.covariance @ slopes.T + np.diag(scatter))
    covariance += np.diag(seat)
    own = np.sqrt(np.diag(covariance))
    same = distances[:, None] == distances
    covariance += same * (CALIPER_DEVIATION / distances[:, None]) ** 2
    return _Ratios(expected, np.log(distances / expected), covariance, own)


def _odd(ratios: _Ratios) -> np.ndarray:
    """Return which placements contradict the others; none where there are too few to tell."""
    logarithms = ratios.logarithms
    if len(logarithms) < 3:
        return np.zeros(len(logarithms), dtype=bool)
    away = np.abs(logarithms - np.median(logarithms))
    return away > np.maximum(ODD, 5 * ratios.own)


def _one_socket(measured: Measurement, length: float) -> Finding:
    first, second = measured.sockets[:2]
    return Finding(
        "error",
        "one-socket",
        where_of([measured]),
        f"sockets {first} and {second} lie at the same place, {1e3 * length:.1f} mm apart, not "
        f"{1e3 * measured.distance:.1f}",
        "all was recorded with the ball in one socket: record the other",
    )


def _other_distance(measured: Measurement, length: float) -> Finding:
    return Finding(
        "error",
        "distance",
        where_of([measured]),
        f"its sockets are {1e3 * length:.1f} mm apart by the model, not "
        f"{1e3 * measured.distance:.1f} as in the others",
        "the base moved between its sockets, or a file is another placement's: record it again",
    )


def _scale_findings(judged: Sequence[Measurement], scale: Scale) -> list[Finding]:
    size = abs(scale.value)
    if size < SUSPECT or abs(np.log1p(scale.value)) < DEVIATIONS * scale.deviation:
        return []
    given = judged[0].distance
    likely = given / (1 + scale.value)
    longer = "longer" if scale.value > 0 else "shorter"
    text = (
        f"the arm comes out {100 * size:.1f} % {longer} than its model (+- "
        f"{100 * scale.deviation:.2f} %); more likely the sockets are {1e3 * likely:.1f} mm apart "
        f"than {1e3 * given:.1f}"
    )
    advice = f"that distance is {_SOURCES[judged[0].distance_source]}"
    level = "error" if size > WRONG else "warning"
    return [Finding(level, "scale", where_of(judged), text, advice)]
