"""Readings of the turns in a file of poses: which fits, where they do not as their columns say.

Programs write turns in many ways that look alike. Each reading is an explanation of the file, and
its evidence is that of the angles a_i and places t_i which the poses leave, their scales unknown:

    ln L = -3/2 N (ln median(a^2) + ln median(t^2))
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from ...recorder import Sample
from ..data import FrameError, hand_eye, rotation_matrices
from ..robot import matrix_rpy, turn
from .task import Flanges

AS_IS = "as they stand"
SURE = math.log(1000)
"""Log Bayes factor from which another reading is named."""
LEAST_ANGLE, LEAST_PLACE = 1e-4, 1e-4
"""Angles [rad] and places [m] that no camera tells apart."""
NEARER = 0.25
"""Share of angles or places that the right reading leaves at most: of mirrored places none does."""
FITS = 0.1
"""Angle up to which a reading fits [rad]."""


def turns_of(samples: Sequence[Sample]) -> dict[str, np.ndarray]:
    """Return the rotations of samples by each reading of their numbers, shape (N, 3, 3)."""
    quaternions = np.array([s.orientation for s in samples], dtype=float)
    turns = {AS_IS: rotation_matrices(quaternions)}
    numbers = [s.turn for s in samples]
    if any(len(row) != 3 for row in numbers):
        return {
            **turns,
            "quaternions with w first": rotation_matrices(quaternions[:, [1, 2, 3, 0]]),
        }
    for unit, factor in (("", 1.0), (" in degrees", math.pi / 180)):
        angles = factor * np.array(numbers)
        turns[f"rotation vectors{unit}"] = turn(angles)
        turns[f"roll, pitch, yaw{unit} (Rz Ry Rx)"] = np.array([matrix_rpy(v) for v in angles])
        turns[f"Euler angles{unit} about z, y, x (Rz Ry Rx)"] = _product(angles, "zyx")
        turns[f"Euler angles{unit} about x, y, z (Rx Ry Rz)"] = _product(angles, "xyz")
        turns[f"Euler angles{unit} about z, y, z (Rz Ry Rz)"] = _product(angles, "zyz")
    return turns


def _product(angles: np.ndarray, axes: str) -> np.ndarray:
    """Return products of turns about axes, angle by angle, shape (N, 3, 3)."""
    vectors = np.eye(3)[["xyz".index(axis) for axis in axes]]
    a, b, c = [turn(column[:, None] * v) for column, v in zip(angles.T, vectors, strict=True)]
    return a @ b @ c


def poses_of(samples: Sequence[Sample]) -> dict[str, np.ndarray]:
    """Return the poses of samples by each reading, shape (N, 4, 4)."""
    poses: dict[str, np.ndarray] = {}
    for name, R in turns_of(samples).items():
        T = np.tile(np.eye(4), (len(samples), 1, 1))
        T[:, :3, :3], T[:, :3, 3] = R, [s.point or (0.0, 0.0, 0.0) for s in samples]
        transposed = T.copy()
        transposed[:, :3, :3] = R.swapaxes(1, 2)
        prefix = "" if name == AS_IS else f"{name}, "
        poses[name] = T
        poses[f"{prefix}turns transposed or inverse, places not"] = transposed
        poses[f"{prefix}inverse poses"] = np.linalg.inv(T)
    return poses


def fitting_reading(
    samples: Sequence[Sample], flange_poses: Flanges, side: Callable[[np.ndarray], np.ndarray]
) -> str:
    """Return in words how poses are to be read; empty where no reading fits far better.

    Whole poses that are inverse are another camera's, too: of them the caller speaks.
    """
    evidence, residuals = dict[str, float](), dict[str, tuple[float, float]]()
    for name, T in poses_of(samples).items():
        M = side(T)
        try:
            start = hand_eye(flange_poses.R, flange_poses.p, M[:, :3, :3], M[:, :3, 3])
        except FrameError:
            return ""
        a = max(float(np.median(start.angles)), LEAST_ANGLE)
        t = max(float(np.median(start.distances)), LEAST_PLACE)
        evidence[name], residuals[name] = -3 * len(T) * (math.log(a) + math.log(t)), (a, t)
    best = max(evidence, key=evidence.__getitem__)
    gain = evidence[best] - evidence[AS_IS]
    if best in (AS_IS, "inverse poses") or gain < SURE or residuals[best][0] > FITS:
        return ""
    (a0, t0), (a, t) = residuals[AS_IS], residuals[best]
    if a > NEARER * a0 and t > NEARER * t0:
        return ""
    return (
        f"as its columns say, the poses leave {a0:.2g} rad and {1e3 * t0:.1f} mm; read as {best}, "
        f"{a:.2g} rad and {1e3 * t:.1f} mm (log Bayes factor {gain:.0f}): write them as x,y,z and "
        "qx,qy,qz,qw of the board in the camera, or name the columns by what they hold"
    )
