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
NEARLY_HALF = 1e-6
"""Sine of a turn by nearly 180 degrees, whose axis the symmetric part of its matrix tells."""


def turns_and_rates(vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return exp(w) of vectors, shape (..., 3) [rad], and its rates J, shapes (..., 3, 3).

    exp(w + dw) = exp(w) exp(J dw) for small dw, with a = |w|, K v = w x v, and

        exp(w) = I + sin(a) / a K + (1 - cos a) / a^2 K^2
        J = I - (1 - cos a) / a^2 K + (a - sin a) / a^3 K^2
    """
    squares = np.sum(vectors**2, axis=-1)
    angles = np.sqrt(squares)[..., None, None]
    turns = angles.clip(min=LEAST)
    halves = turns / 2
    sine_share = np.sin(turns) / turns
    half_share = np.sin(halves) / halves
    cosine_share = 0.5 * half_share**2
    cubic_share = np.where(
        angles < SMALL,
        1 / 6,
        (1 - sine_share) / np.maximum(angles, SMALL) ** 2,
    )
    K = cross_matrices(vectors)
    K_squared = K @ K
    matrices = _IDENTITY + sine_share * K + cosine_share * K_squared
    rates = _IDENTITY - cosine_share * K + cubic_share * K_squared
    return matrices, rates


def turn(vector: np.ndarray) -> np.ndarray:
    """Return exp(w), the rotations by vectors, shape (..., 3) [rad], as (..., 3, 3)."""
    matrices, _ = turns_and_rates(vector)
    return matrices


def cross_matrices(vector: np.ndarray) -> np.ndarray:
    """Return the matrices K with K v = w x v, shape (..., 3, 3)."""
    return np.tensordot(vector, _OF_AXES, 1)


def rotation_vectors(R: np.ndarray) -> np.ndarray:
    """Return the axes of rotations, shape (N, 3, 3), times their angles, shape (N, 3) [rad].

    The sines of the axes stand in the antisymmetric part of R, and 1 + 2 cos(angle) is its trace.
    """
    differences = R - R.swapaxes(1, 2)
    sines = differences[:, (2, 0, 1), (1, 2, 0)] / 2
    trace = np.trace(R, axis1=1, axis2=2)
    cosine = (trace - 1) / 2
    sine = np.linalg.norm(sines, axis=1)
    angle = np.arctan2(sine, cosine)
    scale = np.where(sine > 1e-9, angle / sine.clip(1e-9), 1.0)
    vectors = sines * scale[:, None]
    half_turns = (sine < NEARLY_HALF) & (cosine < 0)
    if half_turns.any():
        axes = _axes_of_half_turns(R[half_turns], sines[half_turns])
        vectors[half_turns] = axes * angle[half_turns, None]
    return vectors


def _axes_of_half_turns(
    R: np.ndarray,
    sines: np.ndarray,
) -> np.ndarray:
    """Return the axes a of turns by nearly 180 degrees, R = 2 a a^T - I, shape (N, 3)."""
    symmetric = (R + R.swapaxes(1, 2)) / 2
    squares = (symmetric + _IDENTITY) / 2
    longest = np.diagonal(squares, axis1=1, axis2=2).argmax(axis=1)
    axes = squares[np.arange(len(R)), :, longest]
    along = np.sum(axes * sines, axis=1)
    lengths: np.ndarray = np.linalg.norm(axes, axis=1)
    signs = np.where(along < 0, -1.0, 1.0)
    return axes * (signs / lengths)[:, None]


def matrix_rpy(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return Rz(yaw) Ry(pitch) Rx(roll) of numbers, shape (..., 3), as (..., 3, 3)."""
    angles = np.moveaxis(np.asarray(rpy, dtype=float), -1, 0)
    sr, sp, sy = np.sin(angles)
    cr, cp, cy = np.cos(angles)
    first_row = (
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
    )
    second_row = (
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
    )
    third_row = (
        -sp,
        cp * sr,
        cp * cr,
    )
    rows = np.array([first_row, second_row, third_row])
    return np.moveaxis(rows, (0, 1), (-2, -1))


def rpy_axes(rpy: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the axes about which roll, pitch and yaw turn, in columns, shape (..., 3, 3)."""
    by_all = matrix_rpy(rpy)
    by_yaw = matrix_rpy(np.asarray(rpy) * (0, 0, 1))
    roll_axis = by_all[..., :1]
    other_axes = by_yaw[..., 1:]
    return np.concatenate([roll_axis, other_axes], axis=-1)


def rpy_of(
    R: np.ndarray,
    locked_yaw: float | None = None,
) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a rotation [rad]; of two sets, the one with |pitch| <= 90 deg.

    Where roll and yaw are one turn, the yaw is the one given; None for a roll of zero.
    """
    level = float(np.hypot(R[0, 0], R[1, 0]))
    pitch = float(np.arctan2(0.0 - R[2, 0], level))
    if level >= LOCKED:
        yaw = float(np.arctan2(R[1, 0], R[0, 0]))
    elif locked_yaw is not None:
        yaw = locked_yaw
    else:
        return 0.0, pitch, float(np.arctan2(-R[0, 1], R[1, 1]))
    # the roll that is left, so that both together are right where each by itself is hardly told
    s = np.sin(yaw)
    c = np.cos(yaw)
    sine = s * R[0, 2] - c * R[1, 2]
    cosine = c * R[1, 1] - s * R[0, 1]
    return float(np.arctan2(sine, cosine)), pitch, yaw


def angles_near(
    R: np.ndarray,
    angles: np.ndarray,
) -> np.ndarray:
    """Return roll, pitch and yaw of a rotation, of all its sets the nearest to others [rad]."""
    roll, pitch, yaw = rpy_of(R, locked_yaw=float(angles[2]))
    flipped = [roll + np.pi, np.pi - pitch, yaw + np.pi]
    candidates = np.array([[roll, pitch, yaw], flipped])
    whole_turns = np.round((candidates - angles) / (2 * np.pi))
    candidates -= 2 * np.pi * whole_turns
    distances = np.abs(candidates - angles).sum(axis=1)
    return candidates[int(np.argmin(distances))]


def rotation_matrices(quaternions: np.ndarray) -> np.ndarray:
    """Return the rotations of unit quaternions x, y, z, w, shape (..., 4), as (..., 3, 3).

    R = I + 2 w K + 2 K^2, with K v = (x, y, z) x v.
    """
    K = cross_matrices(quaternions[..., :3])
    w = quaternions[..., 3, None, None]
    return np.eye(3) + 2 * w * K + 2 * K @ K
