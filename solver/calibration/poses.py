"""Poses as 4 x 4 matrices, checked, from and to numbers; and joint positions along them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MukcaError
from ..data import rotation_matrices
from ..robot import matrix_rpy

SKEWED = 1e-3
"""Largest error of a rotation matrix that was only rounded."""
DETOUR = (0.02, 0.1)
"""Neighbours are joined where half way between them the tool is this far off the way at most, and
half the way itself [m], [rad]."""


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

    Rotations that were rounded are made rigid again; what is no rigid motion is a
    :class:`PoseError`.
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
    if given.shape == (3, 3) and np.abs(_nearest_rotation(given) - given).max() < SKEWED:
        raise PoseError(
            f"{what} of shape (3, 3): a rotation alone; give the pose [R p; 0 0 0 1], shape (4, 4)"
        )
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
    """Return poses, shape (..., 4, 4), of x y z with roll pitch yaw, or with qx qy qz qw."""
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
    if (wrong := np.flatnonzero(~(abs(length - 1) < SKEWED))).size:
        where = f"row {wrong[0]}: " if given.ndim > 1 else ""
        raise PoseError(f"{where}a quaternion qx qy qz qw needs length 1")
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


FAR = 20.0
"""No arm is this large [m]."""


class CommandError(MukcaError):
    """A pose that no joint positions within the limits reach, as far as was found."""

    def __init__(self, message: str, positions: np.ndarray, left: np.ndarray, joint: str) -> None:
        super().__init__(message)
        self.positions = positions
        """The nearest joint positions, shape (m,) [rad]."""
        self.left = left
        """Distance [m] and angle [rad] that are left there, shape (2,)."""
        self.joint = joint
        """The joint that stands at its limit there; empty for none."""


@dataclass(frozen=True)
class JointPath:
    """Joint positions for N poses, each near those before."""

    joint_names: tuple[str, ...]
    positions: np.ndarray
    """Shape (N, m) [rad]; where a pose is not reached, the nearest that were found."""
    reached: np.ndarray
    """True where the tool stands at the pose, shape (N,)."""
    left: np.ndarray
    """Distance [m] and angle [rad] left, shape (N, 2)."""
    rounds: np.ndarray
    """Steps that it took, shape (N,)."""
    at_limit: tuple[str, ...]
    """The joint that stands at its limit, pose by pose; empty for none."""
    singular_value: np.ndarray
    """Smallest singular value of the Jacobian, shape (N,): near 0, joints must turn fast."""
    jumps: tuple[int, ...]
    """Poses to which the joints cannot go straight from the pose before: the tool would leave the
    way."""

    def checked(self) -> np.ndarray:
        """Return the positions, shape (N, m) [rad].

        Raises:
            CommandError: A pose is not reached, or the joints jump between two.
        """
        wrong = [*np.flatnonzero(~self.reached).tolist(), *self.jumps]
        if wrong:
            row = min(wrong)
            where = f"pose {row}"
            here = self.positions[row], self.left[row], self.at_limit[row]
            if not self.reached[row]:
                raise not_reached(where, *here)
            raise CommandError(
                f"{where}: from the pose before the joints jump, and the tool would leave the way; "
                "start in another posture, or give poses between them",
                *here,
            )
        return self.positions


def not_reached(where: str, positions: np.ndarray, left: np.ndarray, joint: str) -> CommandError:
    """Return the error that says how far a pose is from being reached."""
    cure = "give a pose within reach, or start near another posture"
    if left[0] > FAR:
        cure = "poses are in metres: is this one in millimetres?"
    return CommandError(
        f"{where}: not reached; at the nearest joint positions found {1e3 * left[0]:.6g} mm and "
        f"{1e3 * left[1]:.6g} mrad are left, with {joint or 'no joint'} at its limit; {cure}",
        positions,
        left,
        joint,
    )


def find_jumps(q: np.ndarray, pose: Callable[[np.ndarray], np.ndarray], turns: bool) -> list[int]:
    """Return the rows to which the joints do not go straight, by the tool's way and its turns."""
    one, between, other = (pose(rows) for rows in (q[:-1], (q[:-1] + q[1:]) / 2, q[1:]))
    jumps = np.zeros(len(one), dtype=bool)
    for distance, least in list(zip((_distance, _angle), DETOUR, strict=True))[: 1 + turns]:
        direct = distance(one, other)
        detour = distance(one, between) + distance(between, other) - direct
        jumps |= detour > 2 * least + direct
    return (1 + np.flatnonzero(jumps)).tolist()


def _distance(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.linalg.norm(other[:, :3, 3] - one[:, :3, 3], axis=1)


def _angle(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    trace = np.einsum("nij,nij->n", one[:, :3, :3], other[:, :3, :3])
    return np.arccos(((trace - 1) / 2).clip(-1, 1))
