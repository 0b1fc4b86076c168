"""Predicted errors of distances: in the workspace, and near recorded places."""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from ..identification.data import Load, Measurement
from ..identification.inference import Posterior
from ..identification.robot import Robot, workspace
from ..results import DistanceDeviation
from .postures import SWAY, poses_near
from .projections import bisected, pair_lengths
from .uncertainty import distance_deviations

WITHIN_ONE, LARGE_GAP = 0.6827, 4.0
"""Share within a deviation; and deviations from which on a gap counts from one side only."""
NEAR, NEARBY = 0.06, 60
"""Standard deviation per axis of a place near a recorded one [m], and how many are thought of."""
PAIRS = 200
"""Random distances in the workspace."""


def likely_errors(gap: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return what 68 % of the errors gap + deviation z do not exceed in size, shape (N,) [m]."""
    phi = np.vectorize(NormalDist().cdf)
    ratios = np.linspace(0, LARGE_GAP, 31)

    def too_few(sizes: np.ndarray) -> np.ndarray:
        share = phi(sizes - ratios) - phi(-sizes - ratios)
        return share <= WITHIN_ONE

    sizes = bisected(too_few, ratios, ratios + 1, rounds=20)
    ratio = np.abs(gap) / deviation
    size = np.interp(ratio, ratios, sizes)
    beyond = np.maximum(ratio - LARGE_GAP, 0)
    return deviation * (size + beyond)


def predicted_errors(
    posterior: Posterior,
    load: Load,
    q: np.ndarray,
    exported: np.ndarray | None = None,
) -> DistanceDeviation:
    """Return the predicted errors of distances between pairs of poses."""
    poses = load.at(posterior.model.robot, q)
    distances, deviation = distance_deviations(posterior, poses)
    export_error = None
    if exported is not None:
        points = posterior.model.ball.points(exported, q)
        gap = pair_lengths(points) - distances
        errors = likely_errors(gap, deviation)
        export_error = float(np.median(errors))
    return DistanceDeviation(
        median=float(np.median(deviation)),
        worst=float(deviation.max()),
        length=float(np.median(distances)),
        alone=export_error,
    )


def workspace_errors(
    posterior: Posterior,
    load: Load,
    exported: np.ndarray | None = None,
) -> DistanceDeviation:
    """Return the predicted errors of distances between random poses."""
    q = workspace(posterior.model.robot, 2 * PAIRS)
    return predicted_errors(posterior, load, q, exported)


def errors_near(
    posterior: Posterior,
    load: Load,
    recorded: Sequence[Measurement],
    exported: np.ndarray | None,
) -> DistanceDeviation | None:
    """Return the predicted errors of distances near recorded places, where they are largest.

    See :func:`neighbourhoods`; both ends of a distance are near one place.
    """
    nearby = neighbourhoods(posterior.model.robot, recorded)
    deviations = [predicted_errors(posterior, load, q, exported) for q in nearby]
    return max(
        deviations,
        key=lambda deviation: deviation.alone or deviation.median,
        default=None,
    )


def neighbourhoods(
    robot: Robot,
    recorded: Sequence[Measurement],
) -> list[np.ndarray]:
    """Return an even number of poses near each recorded place that has two in reach.

    Near is some 0.1 m from a place, in configurations like those recorded there; of measured points
    each is a neighbour of one recorded posture.
    """
    nearby: list[np.ndarray] = []
    for m in recorded:
        sway = SWAY if m.kind == "sockets" else 0.0
        q, _ = poses_near(robot, m.positions, (NEARBY, 1), NEAR, sway=sway)
        pairs = len(q) // 2
        if pairs:
            nearby.append(q[: 2 * pairs])
    return nearby
