"""The poses of a chain's links as CasADi expressions, for what other programs compute.

Numbers of many rows are computed by :mod:`.segments`, with nothing to build before. A joint with
the frame (p, R) in the link before it, the axis a and the position q has

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


class JointFrame(NamedTuple):
    """Frame of a joint in the link before it, as expressions, while the joint is at zero."""

    p: Any
    """Its origin, shape (3,) [m]."""
    R: Any
    """Its rotation, shape (3, 3)."""


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
    frames: list[JointFrame] = []
    for frame in frames_of(joints):
        frames.append(JointFrame(ca.DM(frame[:, 0]), ca.DM(frame[:, 1:4])))
    return frames


def frames_of(joints: Sequence[Joint]) -> np.ndarray:
    """Return the frames [p | R | axes] of joints as written, shape (joints, 3, 7)."""
    numbers = [joint.origin.numbers for joint in joints]
    return frames_of_origins(np.reshape(numbers, (-1, 6)))


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
    of_q: dict[int, Motion] = {}
    for i, motions in enumerate(joint_motions(joints, q.shape[0])):
        frame = frames[i]
        p = p + turn @ frame.p
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
    return ChainMotion(links, in_order)


def joint_motions(
    joints: Sequence[Joint],
    columns: int,
) -> list[list[JointMotion]]:
    """Return each joint's motions: that of its position, then its tilts about b and c.

    A configuration has a number of columns, one for each motion.
    """
    moving = [i for i, joint in enumerate(joints) if joint.actuated]
    motions: list[list[JointMotion]] = [[] for _ in joints]
    for column in range(columns):
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
