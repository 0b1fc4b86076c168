"""Errors of placements that are left out of a fit, one part after the other."""

from typing import NamedTuple

import numpy as np

from ..data import FrameError, fit_pose
from ..inference import FitPosterior, stepped

PARTS = 5
"""Placements are divided into at most this many parts, and each part is left out of a fit once. One
fit for each placement would take too long where there are many."""


class MeanFall(NamedTuple):
    """Mean fall of held-out errors from model to model."""

    mean: float
    """[m]."""
    deviation: float
    """Its standard error [m]."""


def mean_fall(before: np.ndarray, after: np.ndarray) -> MeanFall:
    """Return the mean fall of held-out errors, but for placements that have none."""
    falls = before - after
    falls = falls[np.isfinite(falls)]
    deviation = falls.std(ddof=1) / np.sqrt(len(falls))
    return MeanFall(float(falls.mean()), float(deviation))


def held_out_errors(posterior: FitPosterior) -> np.ndarray:
    """Return each placement's error by a fit to others [m]; NaN where a frame is not tied then."""
    names = posterior.data.placements
    errors = np.full(len(names), np.nan)
    for part in range(min(PARTS, len(names))):
        held_out = names[part::PARTS]
        try:
            others = posterior.data.without(held_out)
            x = stepped(posterior, others).x
        except FrameError:
            continue
        for k in range(part, len(names), PARTS):
            errors[k] = _mean_error(posterior, x, names[k])
    return errors


def _mean_error(posterior: FitPosterior, x: np.ndarray, placement: str) -> float:
    """Return the mean distance of balls from their socket's mean or measured place [m]."""
    data = posterior.data
    samples = data.only(data.rows_of(placement))
    points = posterior.model.predict(x, samples)
    sockets = samples.sockets
    errors: list[np.ndarray] = []
    for socket in np.unique(sockets[sockets >= 0]):
        balls = points[sockets == socket]
        errors.append(balls - balls.mean(axis=0))
    by_instrument = sockets < 0
    if by_instrument.any():
        balls = points[by_instrument]
        measured = samples.points[by_instrument]
        pose = fit_pose(measured, balls)
        errors.append(balls - pose.apply(measured))
    distances = np.linalg.norm(np.concatenate(errors), axis=1)
    return float(distances.mean())
