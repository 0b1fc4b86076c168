"""The position of the ball as a function of the parameters and the joint positions.

There is one forward kinematics, :func:`frames_and_motions`, a CasADi expression, so that its
derivatives are exact. A joint with the origin (p, rpy) in the link before it, the axis a and the
position q has

    T(i-1, i) = [ R(rpy) R(a, q) | p ]            revolute, continuous (Rodrigues' formula)
    T(i-1, i) = [ R(rpy)         | p + R(rpy) a q ]   prismatic

with R(rpy) = Rz(yaw) Ry(pitch) Rx(roll), as in URDF. One that bends under load also tilts about the
two axes :func:`across` its own, b and c, and the link after it turns by R(b, u) R(c, v) more. A
configuration is a row of m positions, or of 3 m: with all tilts u, then all tilts v.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from .chain import Joint, across
from .row_function import RowFunction
from .urdf import Robot
from .urdf_text import Origin


def rotation(axis: Sequence[float], angle: Any) -> Any:
    """Return the rotation matrix about a unit axis, by Rodrigues' formula.

    R = a a^T + cos(angle) (I - a a^T) + sin(angle) K, where K v is the cross product of a and v.
    """
    along, beside, K = _parts_about(*axis)
    return along + ca.cos(angle) * beside + ca.sin(angle) * K


@lru_cache(maxsize=64)
def _parts_about(x: float, y: float, z: float) -> tuple[Any, Any, Any]:
    along = np.outer((x, y, z), (x, y, z))
    K = ca.DM([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return ca.DM(along), ca.DM(np.eye(3) - along), K


def rotation_rpy(rpy: Any) -> Any:
    """Return R(rpy): roll about x, then pitch about y, then yaw about z, of fixed axes."""
    return rotation((0, 0, 1), rpy[2]) @ rotation((0, 1, 0), rpy[1]) @ rotation((1, 0, 0), rpy[0])


def nominal_origins(joints: Sequence[Joint]) -> Any:
    """Return the origins of joints as written, one after the other, shape (6 joints,)."""
    return ca.DM([number for joint in joints for number in (*joint.origin.xyz, *joint.origin.rpy)])


def link_poses(
    joints: Sequence[Joint], q: np.ndarray, origins: np.ndarray | None = None
) -> np.ndarray:
    """Return the poses of the base link and of the joints' child links in the base frame.

    Args:
        joints: The chain.
        q: Positions of the joints that move, shape (N, m) [rad], [m] for a prismatic joint.
        origins: Of all joints, shape (joints, 6); None for those that are written.

    Returns:
        [R | p], shape (N, joints + 1, 3, 4).
    """
    given = nominal_origins(joints).full().ravel() if origins is None else origins.ravel()
    function = _row_function("poses", tuple(map(_kind, joints)), (), q.shape[1])
    return function(q, given, np.zeros(0))[0].reshape(len(q), len(joints) + 1, 3, 4)


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
        return self.axis if self.slides else ca.cross(self.axis, point - self.point)

    @property
    def turn(self) -> Any:
        """The turn of what it carries along: the axis, or zero for a slide."""
        return ca.DM.zeros(3) if self.slides else self.axis


def frames_and_motions(
    joints: Sequence[Joint], origins: Any, q: Any
) -> tuple[list[tuple[Any, Any]], list[Motion], list[Motion]]:
    """Return rotation and position of each joint's child link in the base frame, and the motions.

    Origins are x y z [m] roll pitch yaw [rad] of each joint of the chain, one after the other; q
    are positions of those that move [rad], [m] for a prismatic joint, and their tilts may follow.
    Motions are by each number of the origins, and of q.
    """
    turn, p = ca.DM.eye(3), ca.DM.zeros(3)
    frames: list[tuple[Any, Any]] = []
    of_origins: list[Motion] = []
    of_q = dict[int, Motion]()
    for i, (origin, motions) in enumerate(_motions(joints, origins, q)):
        p = p + turn @ origin[:3]
        turned, turns = turn, list[Motion]()
        for k in (2, 1, 0):  # yaw, pitch, roll
            turns.append(Motion(i, False, turned[:, k], p))
            turned = turned @ rotation(np.eye(3)[k].tolist(), origin[3 + k])
        of_origins += [*(Motion(i, True, turn[:, k], p) for k in range(3)), *turns[::-1]]
        # known angles are one rotation
        turn = turn @ rotation_rpy(origin[3:]) if isinstance(origin, ca.DM) else turned
        for column, axis, slides in motions:
            of_q[column] = Motion(i, slides, turn @ ca.DM(axis), p)
            if slides:
                p = p + of_q[column].axis * q[column]
            else:
                turn = turn @ rotation(axis, q[column])
        frames.append((turn, p))
    return frames, of_origins, [of_q[column] for column in range(len(of_q))]


def ball_position(joints: Sequence[Joint], origins: Any, q: Any) -> Any:
    """Return the ball's centre in the base frame, Phi(Theta, q); see :func:`frames_and_motions`."""
    # Each joint carries it along, back to the base: one point takes a third of what a frame takes.
    p = ca.DM.zeros(3)
    for origin, motions in reversed(_motions(joints, origins, q)):
        for column, axis, slides in reversed(motions):
            p = p + q[column] * ca.DM(axis) if slides else rotation(axis, q[column]) @ p
        for k, of_frame in enumerate(np.eye(3).tolist()):
            p = rotation(of_frame, origin[3 + k]) @ p
        p = p + origin[:3]
    return p


def _motions(joints: Sequence[Joint], origins: Any, q: Any) -> list[tuple[Any, list[Any]]]:
    """Return each joint's origin, and its motions: index in q, axis, and True for a slide."""
    moving = [i for i, joint in enumerate(joints) if joint.actuated]
    parts = [(origins[6 * i : 6 * i + 6], list[Any]()) for i in range(len(joints))]
    for column in range(q.shape[0]):
        tilt, place = divmod(column, len(moving))
        joint, own = joints[moving[place]], parts[moving[place]][1]
        axis = across(joint.axis)[tilt - 1] if tilt else joint.axis
        own.append((column, axis, not tilt and joint.type == "prismatic"))
    return parts


@dataclass(frozen=True)
class Linearisation:
    """Ball positions of N samples, and their derivatives."""

    points: np.ndarray
    """Ball centres, shape (N, 3) [m]."""
    by_parameters: np.ndarray
    """Derivatives by the n free parameters, shape (N, 3, n)."""
    by_joints: np.ndarray
    """Derivatives by the m joint positions, shape (N, 3, m), or with tilts (N, 3, 3 m)."""


class BallModel:
    """The ball's centre as a function of some free origin numbers and the joint positions.

    Args:
        robot: The robot.
        free: Variable origin numbers, as indices into ``robot.origins.ravel()`` (six for each
            joint); all others stay as the URDF has them.
    """

    def __init__(self, robot: Robot, free: Sequence[int]) -> None:
        self.robot = robot
        self.free = np.array(free, dtype=int)
        self._given = robot.origins.ravel()
        self.nominal: np.ndarray = self._given[self.free]
        self._chain = (tuple(map(_kind, robot.joints)), tuple(self.free.tolist()))

    @property
    def function(self) -> Any:
        """The ball's position as a CasADi function of the free numbers and one configuration."""
        x, q = ca.SX.sym("x", len(self.free)), ca.SX.sym("q", len(self.robot.actuated))
        origins = ca.SX(self._given)
        origins[self.free.tolist()] = x
        p = ca.densify(ball_position(self.robot.joints, origins, q))
        return ca.Function("ball", [x, q], [p], ["x", "q"], ["p"])

    def origins(self, parameters: np.ndarray) -> np.ndarray:
        """Return the origins of all joints for values of the free numbers, shape (joints, 6)."""
        origins = self._given.copy()
        origins[self.free] = parameters
        return origins.reshape(-1, 6)

    def turns(self, parameters: np.ndarray) -> np.ndarray:
        """Return the turn of the whole robot about the base's axes, shape (3, n) [rad/rad].

        Only the angles of origins up to the first joint that moves turn it.
        """
        first = next(i for i, joint in enumerate(self.robot.joints) if joint.actuated)
        turned = self.rotations(parameters, np.zeros((1, len(self.robot.actuated))))
        return np.where(self.free // 6 <= first, turned.by_parameters[0], 0.0)

    def points(self, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return the ball's centres in the base frame, shape (N, 3) [m].

        The free numbers have values of shape (n,) [m, rad]; joint positions have shape (N, m)
        [rad], or with tilts (N, 3 m).
        """
        return self._values("points", parameters, positions)[0]

    def linearise(self, parameters: np.ndarray, positions: np.ndarray) -> Linearisation:
        """Return the ball's centres and their derivatives; arguments as for :meth:`points`."""
        points, *slopes = self._values("linear", parameters, positions)
        return Linearisation(points, *self._by_axis(slopes))

    def rotations(self, parameters: np.ndarray, positions: np.ndarray) -> Linearisation:
        """Return rotations of the ball's link, shape (N, 3, 3), in place of the points.

        Derivatives are turns about the base's axes, shapes (N, 3, n) and (N, 3, m) [rad/rad].
        """
        R, *slopes = self._values("rotations", parameters, positions)
        return Linearisation(R.reshape(-1, 3, 3), *self._by_axis(slopes))

    def log_volume(
        self, parameters: np.ndarray, positions: np.ndarray
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the mean logarithm of the volume that the ball sweeps, and its derivatives.

        A small box of joint positions becomes one of ball positions sqrt(det(Jq Jq^T)) times as
        large; with less than three joints there is none, and all are zero. Derivatives are by the
        free numbers, shape (n,), and by a turn of each joint in all positions, shape (m,).
        """
        if positions.shape[1] < 3:
            return 0.0, np.zeros(len(self.free)), 0 * positions[0]
        value, slope, by_joints = self._values("volume", parameters, positions)
        return float(value.mean()), slope.mean(axis=0), by_joints.mean(axis=0)

    def _values(self, kind: str, parameters: np.ndarray, positions: np.ndarray) -> list[np.ndarray]:
        function = _row_function(kind, *self._chain, positions.shape[1])
        return function(positions, self._given, parameters)

    def _by_axis(self, slopes: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
        """Yield slopes of three numbers, shape (N, 3 k), as (N, 3, k)."""
        return (slope.reshape(len(slope), 3, slope.shape[1] // 3) for slope in slopes)


@lru_cache(maxsize=256)
def _row_function(
    kind: str, joints: tuple[Joint, ...], free: tuple[int, ...], columns: int
) -> RowFunction:
    """Return a function of given origins, x and rows q, which arms of like joints share.

    To build one takes longer than most of its calls.
    """
    given, x, q = (
        ca.SX.sym(*s) for s in (("given", 6 * len(joints)), ("x", len(free)), ("q", columns))
    )
    origins, n = ca.SX(given), len(free)
    origins[list(free)] = x
    if kind == "points":
        return RowFunction(kind, [given, x, q], [ca.densify(ball_position(joints, origins, q))])
    frames, of_origins, of_q = frames_and_motions(joints, origins, q)
    if kind == "poses":
        poses = [ca.SX.eye(4)[:3, :], *(ca.horzcat(ca.SX(R), ca.SX(p)) for R, p in frames)]
        return RowFunction(kind, [given, x, q], [ca.vertcat(*poses)])
    motions, (value, p) = [*(of_origins[i] for i in free), *of_q], frames[-1]
    if kind == "rotations":
        slopes = ca.horzcat(*(one.turn for one in motions))
    else:
        value, slopes = ca.densify(p), ca.horzcat(*(one.shift(p) for one in motions))
    if kind == "volume":
        value, slopes = _log_volume([of_origins[i] for i in free], of_q, p)
    return RowFunction(kind, [given, x, q], [value, slopes[:, :n], slopes[:, n:]])


def _log_volume(of_origins: list[Motion], of_q: list[Motion], p: Any) -> tuple[Any, Any]:
    """Return ln sqrt(det(J J^T)) of the ball at p, with J by q, and its slopes by all motions.

    They are the sums of g_i . dJ_i, with g_i = (J J^T)^-1 J_i. A motion with the turn a that shifts
    the ball by s turns the joints beyond it, dJ_i = a x J_i; for the others, dJ_i = a_i x s.
    """
    chain = sorted(of_q, key=lambda one: one.joint)
    J, turns = (ca.horzcat(*of) for of in zip(*((k.shift(p), k.turn) for k in chain), strict=True))
    g = ca.inv(J @ J.T) @ J
    turned, shifted = ca.cross(J, g), ca.cross(g, turns)
    slopes: list[Any] = []
    for motion in (*of_origins, *of_q):
        n = sum(one.joint < motion.joint for one in chain)  # how many of them are before it
        n = next((i for i, one in enumerate(chain, 1) if one is motion), n)
        slopes.append(
            motion.turn.T @ ca.sum2(turned[:, n:]) + motion.shift(p).T @ ca.sum2(shifted[:, :n])
        )
    return 0.5 * ca.log(ca.det(J @ J.T)), ca.horzcat(*slopes)


def _kind(joint: Joint) -> Joint:
    """Return a joint of the same type and axis, and of nothing else."""
    return Joint("", joint.type, "", "", Origin(), joint.axis)
