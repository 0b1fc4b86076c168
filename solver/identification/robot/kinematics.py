"""The position of the ball as a function of the parameters and the joint positions.

There is one forward kinematics, :func:`frames_and_motions`, a CasADi expression, so that its
derivatives are exact. A joint with the frame (p, R) in the link before it, the axis a and the
position q has

    T(i-1, i) = [ R R(a, q) | p ]            revolute, continuous (Rodrigues' formula)
    T(i-1, i) = [ R         | p + R a q ]    prismatic

One that bends under load also tilts about two axes across its own, b and c
(:attr:`.Joint.tilt_axes`), and the link after it turns by R(b, u) R(c, v) more. A configuration is
a row of m positions, or of 3 m: with all tilts u, then all tilts v.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from .chain import Joint, across
from .rotations import matrix_rpy, rpy_axes
from .row_function import RowFunction
from .urdf_text import Origin

NUMBERS = 21
"""Numbers of a :class:`JointFrame`."""


class JointFrame(NamedTuple):
    """Frame of a joint in the link before it, as expressions, while the joint is at zero."""

    p: Any
    """Its origin, shape (3,) [m]."""
    R: Any
    """Its rotation, shape (3, 3)."""
    axes: Any
    """In columns, the axes about which the three numbers of its rotation turn it, shape (3, 3)."""


def rotation(axis: Sequence[float], angle: Any) -> Any:
    """Return the rotation matrix about a unit axis, by Rodrigues' formula.

    R = a a^T + cos(angle) (I - a a^T) + sin(angle) K, where K v is the cross product of a and v.
    """
    along, normal, K = _parts_about(*axis)
    return along + ca.cos(angle) * normal + ca.sin(angle) * K


@lru_cache(maxsize=64)
def _parts_about(
    x: float,
    y: float,
    z: float,
) -> tuple[Any, Any, Any]:
    """Return a a^T, I - a a^T and K of an axis."""
    a = np.array([x, y, z])
    along = np.outer(a, a)
    normal = np.eye(3) - along
    return ca.DM(along), ca.DM(normal), ca.skew(ca.DM(a))


def rotation_rpy(rpy: Any) -> Any:
    """Return R(rpy): roll about x, then pitch about y, then yaw about z, of fixed axes."""
    roll = rotation((1, 0, 0), rpy[0])
    pitch = rotation((0, 1, 0), rpy[1])
    yaw = rotation((0, 0, 1), rpy[2])
    return yaw @ pitch @ roll


def frames_of_origins(origins: np.ndarray) -> np.ndarray:
    """Return frames [p | R | axes] of joints, shape (joints, 3, 7), by their :attr:`Robot.origins`.

    The axes are those of roll, pitch and yaw.
    """
    p = origins[:, :3, None]
    rpy = origins[:, 3:]
    R = matrix_rpy(rpy)
    axes = rpy_axes(rpy)
    return np.concatenate([p, R, axes], axis=2)


def written_frames(joints: Sequence[Joint]) -> list[JointFrame]:
    """Return the frames of joints as written."""
    frames = frames_of_origins(_origins(joints))
    return joint_frames(ca.DM(columns_of(frames)))


def _origins(joints: Sequence[Joint]) -> np.ndarray:
    """Return the origins of joints as written, shape (joints, 6)."""
    numbers = [joint.origin.numbers for joint in joints]
    return np.reshape(numbers, (-1, 6))


def joint_frames(numbers: Any) -> list[JointFrame]:
    """Return frames by their numbers: for each joint the columns of [p | R | axes]."""
    columns = ca.reshape(numbers, 3, numbers.numel() // 3)
    frames: list[JointFrame] = []
    for frame in ca.horzsplit(columns, 7):
        p, R, axes = ca.horzsplit(frame, [0, 1, 4, 7])
        frames.append(JointFrame(p, R, axes))
    return frames


def columns_of(frames: np.ndarray) -> np.ndarray:
    """Return the numbers of :func:`joint_frames`."""
    return frames.swapaxes(1, 2).ravel()


def link_poses(
    joints: Sequence[Joint],
    q: np.ndarray,
    origins: np.ndarray | None = None,
) -> np.ndarray:
    """Return the poses of the base link and of the joints' child links in the base frame.

    Args:
        joints: The chain.
        q: Positions of the joints that move, shape (N, m) [rad], [m] for a prismatic joint.
        origins: Of all joints, shape (joints, 6); None for those that are written.

    Returns:
        [R | p], shape (N, joints + 1, 3, 4).
    """
    if origins is None:
        origins = _origins(joints)
    frames = frames_of_origins(origins)
    kinds = tuple(map(kind_of_joint, joints))
    function = _link_poses(kinds, q.shape[1])
    [poses] = function(q, columns_of(frames))
    return poses.reshape(len(q), len(joints) + 1, 3, 4)


@lru_cache(maxsize=64)
def _link_poses(joints: tuple[Joint, ...], columns: int) -> RowFunction:
    """Return the poses [R | p] of all links, one below the other, as a function of frames and q."""
    numbers = ca.SX.sym("frames", NUMBERS * len(joints))
    q = ca.SX.sym("q", columns)
    links, _, _ = frames_and_motions(joints, joint_frames(numbers), q)
    base = ca.SX.eye(4)[:3, :]
    poses = [base]
    for R, p in links:
        poses.append(ca.horzcat(ca.SX(R), ca.SX(p)))
    return RowFunction("poses", [numbers, q], [ca.vertcat(*poses)])


class LinkPose(NamedTuple):
    """Pose of a joint's child link in the base frame, as expressions."""

    R: Any
    """Its rotation, shape (3, 3)."""
    p: Any
    """Its origin, shape (3,) [m]."""


class Motion(NamedTuple):
    """Motion of what lies beyond a joint by one number of its origin, or by its position."""

    joint: int
    """Index of the joint."""
    slides: bool
    """True for a slide along the axis, false for a turn about it."""
    axis: Any
    """In the base frame."""
    point: Any
    """On the axis."""

    def shift(self, point: Any) -> Any:
        """Return the derivative of a point that it carries along."""
        if self.slides:
            return self.axis
        return ca.cross(self.axis, point - self.point)

    @property
    def turn(self) -> Any:
        """The turn of what it carries along: the axis, or zero for a slide."""
        return ca.DM.zeros(3) if self.slides else self.axis


class ChainMotion(NamedTuple):
    """Poses of a chain's links, and the motions by which they move."""

    links: list[LinkPose]
    """Of each joint's child link."""
    of_frames: list[Motion]
    """By x y z and the three numbers of the rotation of each joint's frame."""
    of_q: list[Motion]
    """By each number of a configuration."""


class JointMotion(NamedTuple):
    """Motion by one number of a configuration, in the frame of its joint."""

    column: int
    """Index of the number."""
    axis: Sequence[float]
    """Unit vector, shape (3,)."""
    slides: bool
    """True for a slide along the axis, false for a turn about it."""

    def of_point(self, point: Any, q: Any) -> Any:
        """Return where a point is after the motion by q [rad], [m]."""
        if self.slides:
            return point + q * ca.DM(self.axis)
        return rotation(self.axis, q) @ point


def frames_and_motions(
    joints: Sequence[Joint],
    frames: Sequence[JointFrame],
    q: Any,
) -> ChainMotion:
    """Return the pose of each joint's child link in the base frame, and the motions.

    Frames are those of the chain's joints; q are positions of those that move [rad], [m] for a
    prismatic joint, and their tilts may follow.
    """
    turn = ca.DM.eye(3)
    p = ca.DM.zeros(3)
    links: list[LinkPose] = []
    of_frames: list[Motion] = []
    of_q: dict[int, Motion] = {}
    for i, motions in enumerate(_joint_motions(joints, q)):
        frame = frames[i]
        p = p + turn @ frame.p
        axes = turn @ frame.axes
        slides = [Motion(i, True, axis, p) for axis in ca.horzsplit(turn, 1)]
        turns = [Motion(i, False, axis, p) for axis in ca.horzsplit(axes, 1)]
        of_frames += slides + turns
        turn = turn @ frame.R
        for column, axis, is_slide in motions:
            direction = turn @ ca.DM(axis)
            of_q[column] = Motion(i, is_slide, direction, p)
            if is_slide:
                p = p + direction * q[column]
            else:
                turn = turn @ rotation(axis, q[column])
        links.append(LinkPose(turn, p))
    in_order = [of_q[column] for column in range(len(of_q))]
    return ChainMotion(links, of_frames, in_order)


def ball_position(
    joints: Sequence[Joint],
    frames: Sequence[JointFrame],
    q: Any,
) -> Any:
    """Return the ball's centre in the base frame, Phi(Theta, q); see :func:`frames_and_motions`."""
    # Each joint carries it along, back to the base: one point takes a third of what a frame takes.
    p = ca.DM.zeros(3)
    pairs = zip(frames, _joint_motions(joints, q), strict=True)
    for frame, motions in reversed([*pairs]):
        for motion in reversed(motions):
            p = motion.of_point(p, q[motion.column])
        p = frame.R @ p + frame.p
    return p


def _joint_motions(
    joints: Sequence[Joint],
    q: Any,
) -> list[list[JointMotion]]:
    """Return each joint's motions: that of its position, then its tilts about b and c."""
    moving = [i for i, joint in enumerate(joints) if joint.actuated]
    motions: list[list[JointMotion]] = [[] for _ in joints]
    for column in range(q.shape[0]):
        tilt, place = divmod(column, len(moving))
        i = moving[place]
        joint = joints[i]
        if tilt == 0:
            motion = JointMotion(column, joint.axis, joint.type == "prismatic")
        else:
            tilt_axes = joint.tilt_axes or across(joint.axis)
            motion = JointMotion(column, tilt_axes[tilt - 1], slides=False)
        motions[i].append(motion)
    return motions


def kind_of_joint(joint: Joint) -> Joint:
    """Return a joint of the same type and axis, and of nothing else."""
    return Joint(
        name="",
        type=joint.type,
        parent="",
        child="",
        origin=Origin(),
        axis=joint.axis,
        tilt_axes=joint.tilt_axes,
    )
