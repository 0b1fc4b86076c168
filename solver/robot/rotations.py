"""Rotations as matrices, as rotation vectors, and as the roll, pitch and yaw of a URDF.

A rotation vector w [rad] turns by its length about its direction, exp(w). Estimated is a small w
that turns a joint's frame in its own axes, R exp(w). A prior of such vectors does not depend on how
the frame is drawn. One of roll, pitch and yaw does: at a pitch of 90 degrees, roll and yaw are one
turn.
"""

from collections.abc import Sequence

import numpy as np

LOCKED = 1e-9
"""Cosine of the pitch, below which roll and yaw are one turn."""
_IDENTITY = np.eye(3)
_OF_AXES = np.cross(_IDENTITY[:, None], _IDENTITY).swapaxes(1, 2)
"""Cross matrices of the axes x, y and z."""
LEAST = 1e-100
"""Angle that stands for none [rad], so that a fraction is one."""
SMALL = 1e-4
"""Angle below which a fraction takes its limit [rad]."""


def turns_and_rates(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return exp(w) of vectors, shape (..., 3) [rad], and its rates J, shapes (..., 3, 3).

    exp(w + dw) = exp(w) exp(J dw) for small dw, with a = |w|, K v = w x v, and

        exp(w) = I + sin(a) / a K + (1 - cos a) / a^2 K^2
        J = I - (1 - cos a) / a^2 K + (a - sin a) / a^3 K^2
    """
    angles = np.sqrt(np.sum(vectors**2, axis=-1))[..., None, None]
    turns = angles.clip(min=LEAST)
    first = np.sin(turns) / turns
    half = np.sin(turns / 2) / (turns / 2)
    last = np.where(angles < SMALL, 1 / 6, (1 - first) / np.maximum(angles, SMALL) ** 2)
    K = cross_matrices(vectors)
    squares = K @ K
    middle = 0.5 * half**2
    turned = _IDENTITY + first * K + middle * squares
    return turned, _IDENTITY - middle * K + last * squares


def turn(vector: np.ndarray) -> np.ndarray:
    """Return exp(w), the rotations by vectors, shape (..., 3) [rad], as (..., 3, 3)."""
    return turns_and_rates(vector)[0]


def cross_matrices(vector: np.ndarray) -> np.ndarray:
    """Return the matrices K with K v = w x v, shape (..., 3, 3)."""
    return np.tensordot(vector, _OF_AXES, 1)


def rotation_vectors(R: np.ndarray) -> np.ndarray:
    """Return the axes of rotations, shape (N, 3, 3), times their angles, shape (N, 3) [rad]."""
    axis = (R - R.swapaxes(1, 2))[:, (2, 0, 1), (1, 2, 0)]
    sine = np.linalg.norm(axis, axis=1) / 2
    angle = np.arctan2(sine, (np.trace(R, axis1=1, axis2=2) - 1) / 2)
    return axis / 2 * np.where(sine > 1e-9, angle / sine.clip(1e-9), 1.0)[:, None]


def matrix_rpy(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll) of numbers, shape (..., 3), as (..., 3, 3)."""
    angles = np.moveaxis(np.asarray(rpy, dtype=float), -1, 0)
    sr, sp, sy = np.sin(angles)
    cr, cp, cy = np.cos(angles)
    rows = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    return np.moveaxis(rows, (0, 1), (-2, -1))


def rpy_axes(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the axes about which roll, pitch and yaw turn, in columns, shape (..., 3, 3)."""
    by_yaw = matrix_rpy(np.asarray(rpy) * (0, 0, 1))
    return np.concatenate([matrix_rpy(rpy)[..., :1], by_yaw[..., 1:]], axis=-1)


def rpy_of(
    R: np.ndarray, locked_yaw: float | None = None
) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a rotation [rad]; of two sets, the one with |pitch| <= 90 deg.

    Where roll and yaw are one turn, the yaw is the one given; None for a roll of zero.
    """
    level = float(np.hypot(R[0, 0], R[1, 0]))
    pitch = float(np.arctan2(0.0 - R[2, 0], level))
    if level < LOCKED and locked_yaw is None:
        return 0.0, pitch, float(np.arctan2(-R[0, 1], R[1, 1]))
    yaw = float(np.arctan2(R[1, 0], R[0, 0]))
    if level < LOCKED and locked_yaw is not None:
        yaw = locked_yaw
    # the roll that is left, so that both together are right where each by itself is hardly told
    s = np.sin(yaw)
    c = np.cos(yaw)
    roll = float(np.arctan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1]))
    return roll, pitch, yaw


def angles_near(R: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw of a rotation, of all its sets the nearest to others [rad]."""
    roll, pitch, yaw = rpy_of(R, locked_yaw=float(angles[2]))
    candidates = np.array(
        [[roll, pitch, yaw], [roll + np.pi, np.pi - pitch, yaw + np.pi]]
    )
    candidates -= 2 * np.pi * np.round((candidates - angles) / (2 * np.pi))
    return candidates[int(np.argmin(np.abs(candidates - angles).sum(axis=1)))]
