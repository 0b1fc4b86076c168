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
SMALL = 1e-4
"""Angle below which a fraction takes its limit [rad]."""


def turn(vector: np.ndarray) -> np.ndarray:
    """Return exp(w), the rotations by vectors, shape (..., 3) [rad], as (..., 3, 3) (Rodrigues)."""
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    K = cross_matrices(vector)
    half = np.sinc(angle / 2 / np.pi)
    return np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * half**2 * K @ K


def turn_rates(vector: np.ndarray) -> np.ndarray:
    """Return J with exp(w + dw) = exp(w) exp(J dw) for small dw, shape (..., 3, 3).

    J = I - (1 - cos a) / a^2 K + (a - sin a) / a^3 K^2, with a = |w| and K v = w x v.
    """
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    K = cross_matrices(vector)
    square = np.maximum(angle, SMALL) ** 2
    last = np.where(angle < SMALL, 1 / 6, (1 - np.sinc(angle / np.pi)) / square)
    return np.eye(3) - 0.5 * np.sinc(angle / 2 / np.pi) ** 2 * K + last * K @ K


def cross_matrices(vector: np.ndarray) -> np.ndarray:
    """Return the matrices K with K v = w x v, shape (..., 3, 3)."""
    K = np.zeros((*vector.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        K[..., i, j] = -vector[..., k]
        K[..., j, i] = vector[..., k]
    return K


def rotation_vectors(R: np.ndarray) -> np.ndarray:
    """Return the axes of rotations, shape (N, 3, 3), times their angles, shape (N, 3) [rad]."""
    axis = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], 1)
    sine = np.linalg.norm(axis, axis=1) / 2
    angle = np.arctan2(sine, (np.trace(R, axis1=1, axis2=2) - 1) / 2)
    return axis / 2 * np.where(sine > 1e-9, angle / sine.clip(1e-9), 1.0)[:, None]


def matrix_rpy(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll) of numbers, shape (3, 3)."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(rpy), np.cos(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rpy_axes(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the axes about which roll, pitch and yaw turn, in columns, shape (3, 3)."""
    _, pitch, yaw = rpy
    roll_axis, pitch_axis = matrix_rpy((0, pitch, yaw))[:, 0], matrix_rpy((0, 0, yaw))[:, 1]
    return np.stack([roll_axis, pitch_axis, np.array([0, 0, 1])], axis=1)


def rpy_of(R: np.ndarray, locked_yaw: float | None = None) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a rotation [rad]; of two sets, the one with |pitch| <= 90 deg.

    Where roll and yaw are one turn, the yaw is the one given; None for a roll of zero.
    """
    level = float(np.hypot(R[0, 0], R[1, 0]))
    yaw = float(np.arctan2(R[1, 0], R[0, 0]))
    if level < LOCKED:
        yaw = float(np.arctan2(-R[0, 1], R[1, 1])) if locked_yaw is None else locked_yaw
    # the roll that is left, so that both together are right where each by itself is hardly told
    s, c = np.sin(yaw), np.cos(yaw)
    roll = float(np.arctan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1]))
    if level < LOCKED and locked_yaw is None:
        roll = 0.0
    return roll, float(np.arctan2(0.0 - R[2, 0], level)), yaw


def angles_near(R: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return roll, pitch and yaw of a rotation, of all its sets the nearest to others [rad]."""
    roll, pitch, yaw = rpy_of(R, locked_yaw=float(angles[2]))
    candidates = np.array([[roll, pitch, yaw], [roll + np.pi, np.pi - pitch, yaw + np.pi]])
    candidates -= 2 * np.pi * np.round((candidates - angles) / (2 * np.pi))
    return candidates[int(np.argmin(np.abs(candidates - angles).sum(axis=1)))]
