"""Leave-one-out cross-validation: a model must predict placements that it was not fitted to."""

from collections.abc import Callable

import numpy as np

from ...data import FrameError, MultiRobotObservations, fit_pose
from ..inference import JointPosterior

PARTS = 5
"""Placements are divided into at most this many parts, and each part is left out of a fit once. One
fit for each placement would take too long where there are many."""

Refit = Callable[[JointPosterior, MultiRobotObservations], JointPosterior]
"""Fits a model again, to other data of the same robots."""


def mean_fall(before: np.ndarray, after: np.ndarray) -> tuple[float, float]:
    """Return the mean fall of held-out errors from model to model, and its standard error [m]."""
    fall = before - after
    fall = fall[np.isfinite(fall)]
    return float(fall.mean()), float(fall.std(ddof=1) / np.sqrt(len(fall)))


def held_out_errors(refit: Refit, whole: JointPosterior) -> np.ndarray:
    """Return each placement's error by a fit to others [m]; NaN where a robot is not tied then."""
    names = whole.scene.placements
    errors = np.full(len(names), np.nan)
    for part in range(min(PARTS, len(names))):
        try:
            found = refit(whole, whole.scene.without(names[part::PARTS]))
        except FrameError:
            continue
        errors[part::PARTS] = [_mean_error(found, whole.scene, p) for p in names[part::PARTS]]
    return errors


def _mean_error(found: JointPosterior, data: MultiRobotObservations, placement: str) -> float:
    """Return the mean distance of balls from their socket's mean or measured place [m]."""
    distances: list[np.ndarray] = []
    for arm, own in zip(found.arms, data.arms, strict=True):
        for socket, (name, _) in enumerate(own.labels):
            rows = own.sockets == socket
            if name == placement and rows.any():
                points = arm.predict(own.positions[rows], own.torques[rows])
                distances.append(np.linalg.norm(points - points.mean(axis=0), axis=1))
        rows = own.rows_of(placement) & (own.sockets < 0)
        if own.instrument is not None and rows.any():
            points = arm.predict(own.positions[rows], own.torques[rows])
            measured = own.instrument.points[rows]
            placed = fit_pose(measured, points).apply(measured)
            distances.append(np.linalg.norm(points - placed, axis=1))
    return float(np.concatenate(distances).mean())
