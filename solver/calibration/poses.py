"""Poses as 4 x 4 matrices: checked, and from and to numbers."""

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MukcaError
from ..data import rotation_matrices
from ..robot import matrix_rpy

SKEWED = 1e-3
"""Largest error of a rotation matrix that was only rounded."""


class PoseError(MukcaError):
    """Numbers that are no pose."""


def one_pose(pose: ArrayLike, what: str) -> np.ndarray:
    """Return one pose, shape (4, 4), checked as by :func:`as_poses`."""
    T = as_poses(pose, what)
    if T.shape != (4, 4) or np.shape(pose) == (3,):
        raise PoseError(f"{what} of shape {np.shape(pose)}: one pose of shape (4, 4) is needed")
    return T


def as_poses(pose: ArrayLike, what: str) -> np.ndarray:
    """Return poses, shape (..., 4, 4), from such or from points, shape (..., 3).

    Rotations that were rounded are made rigid again.

    Raises:
        PoseError: Another shape, numbers that are not finite, or a matrix that is no rigid motion.
    """
    try:
        given = np.asarray(pose, dtype=float)
    except (TypeError, ValueError):
        raise PoseError(f"{what}: {pose!r:.60} are no numbers") from None
    points = given.shape[-2:] != (4, 4) and given.shape[-1:] == (3,)
    if not points and given.shape[-2:] != (4, 4):
        raise PoseError(
            f"{what} of shape {given.shape}: give a pose of shape (4, 4), or a point of shape (3,)"
        )
    if not np.isfinite(given).all():
        raise PoseError(f"{what}: holds numbers that are not finite")
    T = np.broadcast_to(np.eye(4), (*given.shape[:-1], 4, 4)).copy() if points else given.copy()
    if points:
        T[..., :3, 3] = given
        return T
    R = _nearest_rotation(given[..., :3, :3])
    off = max(
        float(np.abs(R - given[..., :3, :3]).max(initial=0)),
        float(np.abs(given[..., 3, :] - [0, 0, 0, 1]).max(initial=0)),
    )
    if off > SKEWED or (np.linalg.det(R) < 0).any():
        raise PoseError(
            f"{what}: not a rigid motion [R p; 0 0 0 1]; its numbers are off one by {off:.2g}"
            if off > SKEWED
            else f"{what}: its rotation is mirrored (left-handed)"
        )
    T[..., :3, :3], T[..., 3, :] = R, [0, 0, 0, 1]
    return T


def half_way(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the poses half way between others, shape (..., 4, 4)."""
    T = (one + other) / 2
    T[..., :3, :3] = _nearest_rotation(T[..., :3, :3])
    return T


def _nearest_rotation(matrix: np.ndarray) -> np.ndarray:
    U, _, Vt = np.linalg.svd(matrix)
    return U @ Vt


def pose_of_numbers(numbers: ArrayLike) -> np.ndarray:
    """Return poses, shape (..., 4, 4), of x y z with roll pitch yaw, or with qx qy qz qw.

    Raises:
        PoseError: Another count of numbers, or a quaternion of length zero.
    """
    given = np.asarray(numbers, dtype=float)
    if given.shape[-1:] not in ((6,), (7,)):
        raise PoseError(f"{given.shape[-1]} numbers: give x y z, and roll pitch yaw or qx qy qz qw")
    T = np.broadcast_to(np.eye(4), (*given.shape[:-1], 4, 4)).copy()
    T[..., :3, 3], turns = given[..., :3], given[..., 3:]
    if turns.shape[-1] == 3:
        T[..., :3, :3] = np.array([matrix_rpy(row) for row in turns.reshape(-1, 3)]).reshape(
            *turns.shape[:-1], 3, 3
        )
        return T
    length = np.linalg.norm(turns, axis=-1, keepdims=True)
    if not (abs(length - 1) < SKEWED).all():
        raise PoseError("a quaternion qx qy qz qw needs length 1")
    T[..., :3, :3] = rotation_matrices(turns / length)
    return T


def quaternion_of(rotations: np.ndarray) -> np.ndarray:
    """Return unit quaternions qx qy qz qw, shape (N, 4), qw not negative, of rotations."""
    found = np.empty((len(rotations), 4))
    for row, R in zip(found, rotations, strict=True):
        # the outer product of the quaternion with itself, times 4 (Bar-Itzhack 2000)
        K = np.empty((4, 4))
        K[:3, :3] = R + R.T + (1 - np.trace(R)) * np.eye(3)
        K[:3, 3] = K[3, :3] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
        K[3, 3] = 1 + np.trace(R)
        longest = K[:, int(np.argmax(np.diag(K)))]
        row[:] = longest / np.linalg.norm(longest) * (1 if longest[3] >= 0 else -1)
    return found
