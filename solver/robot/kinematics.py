"""The position of the ball as a function of the parameters and the joint positions.

There is one forward kinematics, :func:`link_frames`, a CasADi expression, so that its derivatives
are exact. A joint with the origin (p, rpy) in the link before it, the axis a and the position q has

    T(i-1, i) = [ R(rpy) R(a, q) | p ]            revolute, continuous (Rodrigues' formula)
    T(i-1, i) = [ R(rpy)         | p + R(rpy) a q ]   prismatic

with R(rpy) = Rz(yaw) Ry(pitch) Rx(roll), as in URDF. One that bends under load also tilts about the
two axes :func:`across` its own, b and c, and the link after it turns by R(b, u) R(c, v) more. A
configuration is a row of m positions, or of 3 m: with all tilts u, then all tilts v.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np

from .chain import Joint, matrix_rpy, rpy_axes
from .row_function import RowFunction
from .urdf import Robot
from .urdf_text import Origin


def rotation(axis: Sequence[float], angle: Any) -> Any:
    """Return the rotation matrix about a unit axis, by Rodrigues' formula.

    R = a a^T + cos(angle) (I - a a^T) + sin(angle) K, where K v is the cross product of a and v.
    """
    x, y, z = axis
    along = np.outer(axis, axis)
    K = ca.DM([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return ca.DM(along) + ca.cos(angle) * ca.DM(np.eye(3) - along) + ca.sin(angle) * K


def rotation_rpy(rpy: Any) -> Any:
    """Return R(rpy): roll about x, then pitch about y, then yaw about z, of fixed axes."""
    return rotation((0, 0, 1), rpy[2]) @ rotation((0, 1, 0), rpy[1]) @ rotation((1, 0, 0), rpy[0])


def link_frames(joints: Sequence[Joint], origins: Any, q: Any) -> list[tuple[Any, Any]]:
    """Return rotation and position of each joint's child link in the base frame.

    Origins are x y z [m] roll pitch yaw [rad] of each joint of the chain, one after the other; q
    are positions of those that move [rad], [m] for a prismatic joint, and their tilts may follow.
    """
    m = sum(joint.actuated for joint in joints)
    turn, p, moving = ca.DM.eye(3), ca.DM.zeros(3), 0
    frames: list[tuple[Any, Any]] = []
    for i, joint in enumerate(joints):
        origin = origins[6 * i : 6 * i + 6]
        p, turn = p + turn @ origin[:3], turn @ rotation_rpy(origin[3:])
        if joint.type == "prismatic":
            p = p + turn @ ca.DM(joint.axis) * q[moving]
        elif joint.actuated:
            turn = turn @ rotation(joint.axis, q[moving])
        if joint.actuated and q.shape[0] > m:
            for k, axis in enumerate(across(joint.axis), 1):
                turn = turn @ rotation(axis, q[k * m + moving])
        moving += joint.actuated
        frames.append((turn, p))
    return frames


def ball_position(joints: Sequence[Joint], origins: Any, q: Any) -> Any:
    """Return the ball's centre in the base frame, Phi(Theta, q); see :func:`link_frames`."""
    # Each joint carries it along, back to the base: one point takes a third of what a frame takes.
    p = ca.DM.zeros(3)
    for transform in reversed(_transforms(joints, origins, q)):
        p = transform(p)
    return p


def _transforms(joints: Sequence[Joint], origins: Any, q: Any) -> list[Callable[[Any], Any]]:
    """Return each joint's T(i-1, i) as a function of a point, see :func:`_transform`."""
    m = sum(joint.actuated for joint in joints)
    angles = 3 if q.shape[0] > m else 1
    transforms: list[Callable[[Any], Any]] = []
    moving = 0
    for i, joint in enumerate(joints):
        own = [q[k * m + moving] for k in range(angles if joint.actuated else 0)]
        function = _transform(joint.type, joint.axis, len(own))
        transforms.append(partial(function, origins[6 * i : 6 * i + 6], ca.vertcat(*own)))
        moving += joint.actuated
    return transforms


@lru_cache(maxsize=64)
def _transform(kind: str, axis: tuple[float, ...], angles: int) -> Any:
    """Return T(i-1, i): of origin, position (and tilts), and a point of the link after it."""
    origin, own, point = ca.SX.sym("origin", 6), ca.SX.sym("own", angles), ca.SX.sym("p", 3)
    p = point
    for k in range(angles - 1, 0, -1):
        p = rotation(across(axis)[k - 1], own[k]) @ p
    if kind == "prismatic":
        p = p + own[0] * ca.DM(axis)
    elif kind != "fixed":
        p = rotation(axis, own[0]) @ p
    for k, of_frame in enumerate(np.eye(3).tolist()):
        p = rotation(of_frame, origin[3 + k]) @ p
    return ca.Function("T", [origin, own, point], [p + origin[:3]])


def across(axis: Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the two axes about which a joint tilts, at right angles to it and each other."""
    # For one of its frame's axes they are the two others, in the order x, y, z.
    first, second = (np.eye(3)[i] for i in sorted(np.argsort(np.abs(axis))[:2].tolist()))
    b = first - np.dot(first, axis) * np.array(axis)
    b /= np.linalg.norm(b)
    c = np.cross(axis, b)
    c *= np.copysign(1.0, c @ second)
    return tuple(b.tolist()), tuple(c.tolist())


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
        self.nominal: np.ndarray = robot.origins.ravel()[self.free]
        self._given = robot.origins.ravel()
        chain = (tuple(map(_kind, robot.joints)), tuple(self.free.tolist()))
        self._functions = _ball_functions(*chain, len(robot.actuated))
        self._tilted = partial(_ball_functions, *chain, 3 * len(robot.actuated))

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
        axes, before = np.zeros((len(self.robot.joints), 6, 3)), np.eye(3)
        origins = self.origins(parameters)
        for i, joint in enumerate(self.robot.joints):
            axes[i, 3:] = (before @ rpy_axes(origins[i, 3:])).T
            before = before @ matrix_rpy(origins[i, 3:])
            if joint.actuated:
                break
        return axes.reshape(-1, 3)[self.free].T

    def points(self, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return the ball's centres in the base frame, shape (N, 3) [m].

        The free numbers have values of shape (n,) [m, rad]; joint positions have shape (N, m)
        [rad], or with tilts (N, 3 m).
        """
        return self._of(positions).points(positions, self._given, parameters)[0]

    def linearise(self, parameters: np.ndarray, positions: np.ndarray) -> Linearisation:
        """Return the ball's centres and their derivatives; arguments as for :meth:`points`."""
        points, by_x, by_q = self._of(positions).linear(positions, self._given, parameters)
        (N, m), n = positions.shape, len(self.free)
        return Linearisation(points, by_x.reshape(N, 3, n), by_q.reshape(N, 3, m))

    def rotations(self, parameters: np.ndarray, positions: np.ndarray) -> Linearisation:
        """Return rotations of the ball's link, shape (N, 3, 3), in place of the points.

        Derivatives are turns about the base's axes, shapes (N, 3, n) and (N, 3, m) [rad/rad].
        """
        R, by_x, by_q = self._of(positions).rotations(positions, self._given, parameters)
        (N, m), n = positions.shape, len(self.free)
        return Linearisation(R.reshape(N, 3, 3), by_x.reshape(N, 3, n), by_q.reshape(N, 3, m))

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
        value, slope, by_joints = self._functions.volume(positions, self._given, parameters)
        return float(value.mean()), slope.mean(axis=0), by_joints.mean(axis=0)

    def _of(self, positions: np.ndarray) -> "_BallFunctions":
        """Return the functions for joint positions without or with tilts."""
        rigid = positions.shape[1] == len(self.robot.actuated)
        return self._functions if rigid else self._tilted()


class _BallFunctions:
    """Functions of x and rows q, all origins given, so that arms of like joints share them."""

    def __init__(self, joints: tuple[Joint, ...], free: tuple[int, ...], columns: int) -> None:
        given = ca.SX.sym("given", 6 * len(joints))
        self._x, self._q = ca.SX.sym("x", len(free)), ca.SX.sym("q", columns)
        self._inputs = [given, self._x, self._q]
        self._joints, self._origins = joints, ca.SX(given)
        self._origins[list(free)] = self._x
        self._p = ca.densify(ball_position(joints, self._origins, self._q))

    @cached_property
    def points(self) -> RowFunction:
        return RowFunction("points", self._inputs, [self._p])

    @cached_property
    def linear(self) -> RowFunction:
        n = self._x.numel()
        slopes = ca.jacobian(self._p, ca.vertcat(self._x, self._q))
        return RowFunction("linear", self._inputs, [self._p, slopes[:, :n], slopes[:, n:]])

    @cached_property
    def rotations(self) -> RowFunction:
        R, n = link_frames(self._joints, self._origins, self._q)[-1][0], self._x.numel()
        # a turn w changes each column r by w x r, and the sum of r x (w x r) over three is 2 w
        turns: Any = ca.DM.zeros(3, n + self._q.numel())
        for r in (ca.densify(R[:, k]) for k in range(3)):
            J = ca.jacobian(r, ca.vertcat(self._x, self._q))
            turns += ca.vertcat(
                *(r[i - 2] * J[i - 1, :] - r[i - 1] * J[i - 2, :] for i in range(3))
            )
        turns = turns / 2
        return RowFunction("rotations", self._inputs, [R, turns[:, :n], turns[:, n:]])

    @cached_property
    def volume(self) -> RowFunction:
        J = ca.jacobian(self._p, self._q)
        value = 0.5 * ca.log(ca.det(J @ J.T))
        n = self._x.numel()
        slopes = ca.gradient(value, ca.vertcat(self._x, self._q))
        return RowFunction("volume", self._inputs, [value, slopes[:n], slopes[n:]])


@lru_cache(maxsize=64)
def _ball_functions(
    joints: tuple[Joint, ...], free: tuple[int, ...], columns: int
) -> _BallFunctions:
    """The functions of a chain; to build them takes longer than most of their calls."""
    return _BallFunctions(joints, free, columns)


def _kind(joint: Joint) -> Joint:
    """Return a joint of the same type and axis, and of nothing else."""
    return Joint("", joint.type, "", "", Origin(), joint.axis)
