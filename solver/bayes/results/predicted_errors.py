"""Predicted errors of distances: in the workspace, and near recorded places."""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from ...data import Load
from ...results import DistanceDeviation
from ...robot import workspace
from ..inference import Posterior
from .postures import poses_near
from .uncertainty import distance_deviations

WITHIN_ONE, LARGE_GAP = 0.6827, 4.0
"""Share within a deviation; and deviations from which on a gap counts from one side only."""
NEAR, NEARBY = 0.06, 60
"""Standard deviation per axis of a place near a recorded one [m], and how many are thought of."""


def likely_errors(gap: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return what 68 % of the errors gap + deviation z do not exceed in size, shape (N,) [m]."""
    phi = NormalDist().cdf
    ratios = np.linspace(0, LARGE_GAP, 31)
    low = ratios.copy()
    high = ratios + 1
    for _ in range(20):
        middle = (low + high) / 2
        pairs = zip(middle.tolist(), ratios.tolist(), strict=True)
        within = np.array([phi(w - r) - phi(-w - r) for w, r in pairs]) > WITHIN_ONE
        low = np.where(within, low, middle)
        high = np.where(within, middle, high)
    ratio = np.abs(gap) / deviation
    beyond = np.maximum(ratio - LARGE_GAP, 0)
    return deviation * (np.interp(ratio, ratios, high) + beyond)


def predicted_errors(
    posterior: Posterior, load: Load, q: np.ndarray, exported: np.ndarray | None = None
) -> DistanceDeviation:
    """Return the predicted errors of distances between pairs of poses."""
    torque = load.moments(posterior.model.robot, q, None)
    distances, deviation = distance_deviations(posterior, q, torque)
    export_errors = None
    if exported is not None:
        points = posterior.model.ball.points(exported, q)
        gap = np.linalg.norm(points[1::2] - points[::2], axis=1) - distances
        export_errors = float(np.median(likely_errors(gap, deviation)))
    return DistanceDeviation(
        median=float(np.median(deviation)),
        worst=float(deviation.max()),
        length=float(np.median(distances)),
        alone=export_errors,
    )


def workspace_errors(
    posterior: Posterior, load: Load, exported: np.ndarray | None = None, pairs: int = 200
) -> DistanceDeviation:
    """Return the predicted errors of distances between random poses."""
    q = workspace(posterior.model.robot, 2 * pairs)
    return predicted_errors(posterior, load, q, exported)


def errors_near(
    posterior: Posterior,
    load: Load,
    recorded: Sequence[np.ndarray],
    exported: np.ndarray | None = None,
) -> DistanceDeviation | None:
    """Return the predicted errors of distances near recorded places, where they are largest.

    Near is some 0.1 m from a place, in configurations like those recorded there; both ends of a
    distance are near one place. Each placement has joint positions of shape (N, m) [rad].
    """
    deviations: list[DistanceDeviation] = []
    for rows in recorded:
        q, _ = poses_near(posterior.model.robot, rows, (NEARBY, 1), NEAR)
        if len(q) > 1:
            even = q[: len(q) // 2 * 2]
            deviations.append(predicted_errors(posterior, load, even, exported))
    return max(deviations, key=lambda deviation: deviation.alone or deviation.median, default=None)
