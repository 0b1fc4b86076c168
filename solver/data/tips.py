"""A probe's tip on a flange, refitted to points that an instrument measured."""

import numpy as np

from .frames import fit_pose
from .measurements import Measurement

ROUNDS = 8
"""Steps of Gauss-Newton; the tip is linear, and the frame turns hardly once it is fitted."""


def tip_shift(points: np.ndarray, rotations: np.ndarray, measured: Measurement) -> np.ndarray:
    """Return how far a probe's tip sits from the ball, in its link's axes, shape (3,) [m].

    With p_i and R_i the ball and its link by a model, and y_i the measured points, the shift d and
    the frame's pose T minimise the sum of

        |p_i + R_i d - T y_i|^2

    Args:
        points: p, shape (N, 3) [m].
        rotations: R, shape (N, 3, 3).
        measured: y, the points of one frame.
    """
    shift = np.zeros(3)
    axes = np.tile(np.eye(3), (len(points), 1, 1))
    for _ in range(ROUNDS):
        tips = points + rotations @ shift
        places = fit_pose(measured.points, tips).apply(measured.points)
        arms = places - places.mean(axis=0)
        turns = np.cross(arms[:, :, None], axes, axis=1)
        slopes = np.concatenate([rotations, turns, -axes], axis=2).reshape(-1, 9)
        errors = (places - tips).ravel()
        shift = shift + np.linalg.lstsq(slopes, errors, rcond=None)[0][:3]
    return shift


def with_tip(points: np.ndarray, rotations: np.ndarray, measured: Measurement) -> np.ndarray:
    """Return where a model has the tip that fits measured points best, shape (N, 3) [m].

    Arguments are those of :func:`tip_shift`; balls in sockets stay as they are.
    """
    if measured.kind != "points":
        return points
    return points + rotations @ tip_shift(points, rotations, measured)
