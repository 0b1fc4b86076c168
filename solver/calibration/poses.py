"""Setup of a calibrated arm; and poses as 4 x 4 matrices, checked, from and to numbers."""

import warnings
from pathlib import Path
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from ...errors import LENGTH, ROTATION, MukcaError, Quantity
from ..identification.robot import Robot, matrix_rpy, rotation_matrices
from ..results import CalibratedRobot, Payload

HERE = np.eye(4)
Controller = Robot | str | Path | None
"""Model of a controller, or file of its factory calibration; None for the nominal one."""
MARGIN = 1e-3
"""Positions farther than this outside of the limits are said, since encoders err [rad, m]."""
SKEWED = 1e-3
"""Largest error of a rotation matrix that was only rounded."""
NEARLY = 1e-7
"""Largest error of a matrix that one step of Newton makes a rotation, to its square."""


class Setup(TypedDict, total=False):
    """Setup of the arm, its tool, payload and place; each may be left out, or None."""

    tool: str | ArrayLike | None
    """The tool's pose on the flange, shape (4, 4) [m], or the name of a link of the URDF that
    stands still on it; None for the flange itself, the link that carries the ball."""
    payload: Payload | None
    """Mass [kg], and its centre in the flange's frame [m], as ``(1.2, (0, 0, 0.05))``, beyond the
    masses of the URDF; None for the load of the recordings."""
    base: ArrayLike | None
    """Pose of the robot's base in the frame in which poses are given, shape (4, 4) [m]; with a
    ``frame``, that frame's pose there."""
    frame: str | None
    """Of several robots: the frame in which poses are given, as ``right``, another's base, or
    ``right/flange``, see :meth:`.MultiRobotCalibration.base_in`."""
    at: ArrayLike | None
    """Joint positions of that other robot, shape (m,) [rad]."""


class PoseError(MukcaError):
    """Numbers that are no pose."""


def one_pose(pose: ArrayLike, what: str, place: Quantity = LENGTH) -> np.ndarray:
    """Return one pose, shape (4, 4), checked as by :func:`as_poses`; its place is a quantity."""
    T = as_poses(pose, what)
    if T.shape != (4, 4) or np.shape(pose) == (3,):
        raise PoseError(
            f"{what} of shape {np.shape(pose)}: one pose of shape (4, 4) is needed"
        )
    doubt = place.doubt(T[:3, 3])
    if doubt:
        raise PoseError(f"{what}: its place has {doubt}")
    return T


def as_poses(pose: ArrayLike, what: str) -> np.ndarray:
    """Return poses, shape (..., 4, 4), from such or from points, shape (..., 3).

    Rotations that were rounded are made rigid again; what is no rigid motion is a
    :class:`PoseError`.
    """
    try:
        array = np.asarray(pose, dtype=float)
    except (TypeError, ValueError):
        raise PoseError(f"{what}: {pose!r:.60} are no numbers") from None
    points = array.shape[-2:] != (4, 4) and array.shape[-1:] == (3,)
    if not points and array.shape[-2:] != (4, 4):
        raise PoseError(
            f"{what} of shape {array.shape}: give a pose of shape (4, 4), or a point of shape (3,)"
        )
    if not np.isfinite(array).all():
        raise PoseError(f"{what}: holds numbers that are not finite")
    if (
        array.shape == (3, 3)
        and np.abs(_nearest_rotation(array) - array).max() < SKEWED
    ):
        raise PoseError(
            f"{what} of shape (3, 3): a rotation alone; give the pose [R p; 0 0 0 1], shape (4, 4)"
        )
    if points:
        return _translations(array)
    T = _translations(array[..., :3, 3])
    T[..., :3, :3] = _nearest_rotation(array[..., :3, :3])
    skew = float(np.abs(T - array).max(initial=0))
    if skew > SKEWED:
        raise PoseError(
            f"{what}: not a rigid motion [R p; 0 0 0 1]; its numbers are off one by {skew:.2g}"
        )
    if (np.linalg.det(T[..., :3, :3]) < 0).any():
        raise PoseError(f"{what}: its rotation is mirrored (left-handed)")
    return T


def _translations(points: np.ndarray) -> np.ndarray:
    """Return poses at some points that are not turned, shape (..., 4, 4)."""
    T = np.broadcast_to(np.eye(4), (*points.shape[:-1], 4, 4)).copy()
    T[..., :3, 3] = points
    return T


def half_way(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the poses half way between others, shape (..., 4, 4)."""
    T = (first + second) / 2
    T[..., :3, :3] = _nearest_rotation(T[..., :3, :3])
    return T


def _nearest_rotation(matrix: np.ndarray) -> np.ndarray:
    square = matrix.swapaxes(-1, -2) @ matrix
    if np.abs(square - HERE[:3, :3]).max(initial=0) < NEARLY:
        return matrix @ (1.5 * HERE[:3, :3] - square / 2)
    U, _, Vt = np.linalg.svd(matrix)
    return U @ Vt


def pose_of_numbers(numbers: ArrayLike) -> np.ndarray:
    """Return poses, shape (..., 4, 4), of x y z with roll pitch yaw, or with qx qy qz qw."""
    values = np.asarray(numbers, dtype=float)
    if values.shape[-1:] not in ((6,), (7,)):
        raise PoseError(
            f"{values.shape[-1]} numbers: give x y z, and roll pitch yaw or qx qy qz qw"
        )
    T = _translations(values[..., :3])
    turns = values[..., 3:]
    if turns.shape[-1] == 3:
        for row, rpy in enumerate(turns.reshape(-1, 3)):
            doubt = ROTATION.doubt(rpy)
            if doubt:
                where = f"row {row}: " if values.ndim > 1 else ""
                raise PoseError(f"{where}roll, pitch or yaw is {doubt}")
        T[..., :3, :3] = matrix_rpy(turns)
        return T
    length = np.linalg.norm(turns, axis=-1, keepdims=True)
    if (rows := np.flatnonzero(~(abs(length - 1) < SKEWED))).size:
        where = f"row {rows[0]}: " if values.ndim > 1 else ""
        raise PoseError(f"{where}a quaternion qx qy qz qw needs length 1")
    T[..., :3, :3] = rotation_matrices(turns / length)
    return T


def quaternion_of(rotations: np.ndarray) -> np.ndarray:
    """Return unit quaternions qx qy qz qw, shape (N, 4), qw not negative, of rotations."""
    quaternions: list[np.ndarray] = []
    for R in rotations:
        # the outer product of the quaternion with itself, times 4 (Bar-Itzhack 2000)
        turn = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        block = R + R.T + (1 - np.trace(R)) * np.eye(3)
        K = np.block([[block, turn[:, None]], [turn, 1 + np.trace(R)]])
        longest = K[np.argmax(np.diag(K))]
        w = longest[3] + 0.0  # -0.0 is not negative
        quaternions.append(longest / np.copysign(np.linalg.norm(longest), w))
    return np.reshape(quaternions, (-1, 4))


def one_payload(payload: Payload | None) -> Payload | None:
    """Return a payload as numbers; a :class:`PoseError` where it is none."""
    if payload is None:
        return None
    try:
        return float(payload[0]), tuple(map(float, payload[1]))
    except (TypeError, ValueError, IndexError):
        raise PoseError(
            f"payload {payload!r:.60}: give its mass and its centre, as (1.2, (0, 0, 0.05))"
        ) from None


def checked(arm: CalibratedRobot, q: ArrayLike) -> np.ndarray:
    """Return joint positions as rows, and say where a joint is outside of its limits."""
    robot = arm.robot
    rows = arm.positions(q, stacked=True)
    outside = np.argwhere((rows < robot.lower - MARGIN) | (rows > robot.upper + MARGIN))
    for row, i in outside[:1].tolist():
        warnings.warn(
            f"joint positions: row {row}, {robot.joint_names[i]!r} is {rows[row, i]:.4g}, outside "
            f"its limits {robot.lower[i]:.4g} to {robot.upper[i]:.4g}",
            stacklevel=3,
        )
    return rows
