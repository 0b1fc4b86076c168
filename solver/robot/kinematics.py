"""The position of the ball as a function of the parameters and the joint positions.

There is one forward kinematics, :func:`link_frames`, written once as a CasADi expression, so that
its derivatives are exact. Each joint i has an origin (p, rpy) in the link before it, an axis a and
a position q. From the link before it to the link after it leads the transform [rotation |
translation]

    T(i-1, i) = [ R(rpy) R(a, q) | p ]            revolute, continuous (Rodrigues' formula)
    T(i-1, i) = [ R(rpy)         | p + R(rpy) a q ]   prismatic

with R(rpy) = Rz(yaw) Ry(pitch) Rx(roll), the convention of URDF.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .chain import Body, Joint
from .urdf import Robot

__all__ = [
    "BallModel",
    "Linearisation",
    "ball_position",
    "gravity_function",
    "gravity_torques",
    "link_frames",
    "workspace",
]

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
BATCH = 200
"""Rows that are computed at once: the results of more no longer fit into a processor's cache."""


def rotation(axis: Sequence[float], angle: Any) -> Any:
    """Return the rotation matrix about a unit axis, by Rodrigues' formula.

    R = I + sin(angle) K + (1 - cos(angle)) K^2, where K v is the cross product of axis and v.
    """
    x, y, z = axis
    K = ca.DM([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return ca.DM.eye(3) + ca.sin(angle) * K + (1 - ca.cos(angle)) * (K @ K)


def rotation_rpy(rpy: Any) -> Any:
    """Return R(rpy): roll about x, then pitch about y, then yaw about z, of fixed axes."""
    return rotation((0, 0, 1), rpy[2]) @ rotation((0, 1, 0), rpy[1]) @ rotation((1, 0, 0), rpy[0])


def link_frames(joints: Sequence[Joint], origins: Any, q: Any) -> list[tuple[Any, Any]]:
    """Return rotation and position of each joint's child link in the base frame.

    Args:
        joints: The chain's joints, from the base on.
        origins: Their origins, one after the other: x y z [m] roll pitch yaw [rad] each.
        q: Positions of the joints that move, in chain order [rad], [m] for a prismatic joint.
    """
    R_base, p = ca.DM.eye(3), ca.DM.zeros(3)
    frames: list[tuple[Any, Any]] = []
    moving = 0
    for i, joint in enumerate(joints):
        p = p + R_base @ origins[6 * i : 6 * i + 3]
        R_base = R_base @ rotation_rpy(origins[6 * i + 3 : 6 * i + 6])
        if joint.actuated:
            if joint.type == "prismatic":
                p = p + R_base @ ca.DM(joint.axis) * q[moving]
            else:
                R_base = R_base @ rotation(joint.axis, q[moving])
            moving += 1
        frames.append((R_base, p))
    return frames


def ball_position(joints: Sequence[Joint], origins: Any, q: Any) -> Any:
    """Return the ball's centre in the base frame, Phi(Theta, q); see :func:`link_frames`."""
    return link_frames(joints, origins, q)[-1][1]


@dataclass(frozen=True)
class Linearisation:
    """The ball positions of N samples, and their derivatives: a linear model near one point."""

    points: np.ndarray
    """Ball centres, shape (N, 3) [m]."""
    by_parameters: np.ndarray
    """Derivatives by the n free parameters, shape (N, 3, n)."""
    by_joints: np.ndarray
    """Derivatives by the m joint positions, shape (N, 3, m)."""


class BallModel:
    """The ball's centre as a function of some free origin numbers and the joint positions.

    Args:
        robot: The robot.
        free: Which origin numbers are variable, as indices into ``robot.origins.ravel()`` (six for
            each joint); all others stay as the URDF has them.
    """

    def __init__(self, robot: Robot, free: Sequence[int]) -> None:
        self.robot = robot
        self.free = np.array(free, dtype=int)
        self.nominal: np.ndarray = robot.origins.ravel()[self.free]
        self._functions = _ball_functions(robot.joints, tuple(self.free.tolist()))
        self.function = self._functions.ball

    def origins(self, parameters: np.ndarray) -> np.ndarray:
        """Return the origins of all joints for values of the free numbers, shape (joints, 6)."""
        origins = self.robot.origins.ravel()
        origins[self.free] = parameters
        return origins.reshape(-1, 6)

    def points(self, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return the ball's centre in the base frame for each row of joint positions.

        Args:
            parameters: Values of the free numbers, shape (n,) [m, rad].
            positions: Joint positions, shape (N, m) [rad].

        Returns:
            Shape (N, 3) [m].
        """
        return self._functions.evaluate("ball", parameters, positions)[0]

    def linearise(self, parameters: np.ndarray, positions: np.ndarray) -> Linearisation:
        """Return the ball's centres and their derivatives; arguments as for :meth:`points`."""
        N, n, m = len(positions), len(self.free), positions.shape[1]
        p, by_x, by_q = self._functions.evaluate("linear", parameters, positions)
        return Linearisation(
            p,
            by_x.reshape(N, n, 3).transpose(0, 2, 1),
            by_q.reshape(N, m, 3).transpose(0, 2, 1),
        )

    def log_volume(self, parameters: np.ndarray, positions: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the mean logarithm of the volume that the ball sweeps, and its derivatives.

        A small box of joint positions becomes a body of ball positions whose volume is
        sqrt(det(Jq Jq^T)) times as large. For a robot of less than three joints there is no
        volume, and both are zero.

        Args:
            parameters: The free numbers, shape (n,).
            positions: Joint positions, shape (N, m).

        Returns:
            The mean over the positions, and its derivatives by the free numbers, shape (n,).
        """
        if positions.shape[1] < 3:
            return 0.0, np.zeros(len(self.free))
        value, slope = self._functions.evaluate("volume", parameters, positions)
        return float(value.mean()), slope.mean(axis=0)


class _BallFunctions:
    """The ball's position, its derivatives and its volume as CasADi functions of x and q."""

    def __init__(self, joints: tuple[Joint, ...], free: tuple[int, ...]) -> None:
        numbers = [value for joint in joints for value in (*joint.origin.xyz, *joint.origin.rpy)]
        self._x = ca.SX.sym("x", len(free))
        self._q = ca.SX.sym("q", sum(joint.actuated for joint in joints))
        origins = ca.SX(numbers)
        origins[list(free)] = self._x
        self._p = ca.densify(ball_position(joints, origins, self._q))
        self.ball = ca.Function("ball", [self._x, self._q], [self._p], ["x", "q"], ["p"])
        self._mapped: dict[tuple[str, int], Any] = {}

    @cached_property
    def linear(self) -> Any:
        slopes = [ca.densify(ca.jacobian(self._p, by)) for by in (self._x, self._q)]
        return ca.Function("linear", [self._x, self._q], [self._p, *slopes], {"cse": True})

    @cached_property
    def volume(self) -> Any:
        J = ca.jacobian(self._p, self._q)
        value = ca.densify(0.5 * ca.log(ca.det(J @ J.T)))
        slope = ca.densify(ca.gradient(value, self._x))
        return ca.Function("volume", [self._x, self._q], [value, slope], {"cse": True})

    def evaluate(
        self, name: str, parameters: np.ndarray, positions: np.ndarray
    ) -> list[np.ndarray]:
        """Return a function's results for each row of joint positions, in rows too.

        CasADi's matrices lie in memory column by column and NumPy's row by row, so each result is
        its own transpose, and nothing is copied.
        """
        function = getattr(self, name)
        shapes = [function.size_out(i) for i in range(function.n_out())]
        results = [np.empty((len(positions), columns, rows)) for rows, columns in shapes]
        for begin in range(0, len(positions), BATCH):
            batch = slice(begin, begin + BATCH)
            q = np.ascontiguousarray(positions[batch], dtype=float).ravel()
            x = np.tile(np.asarray(parameters, dtype=float), len(positions[batch]))
            buffer, trigger = self._over(name, len(positions[batch])).buffer()
            for i, values in enumerate((x, q)):
                buffer.set_arg(i, values.data)
            for i, values in enumerate(results):
                buffer.set_res(i, values[batch].ravel().data)
            trigger()
        return [values.reshape(-1, values.shape[2]) for values in results]

    def _over(self, name: str, rows: int) -> Any:
        """Return a function mapped over so many rows, built once for each number."""
        if (name, rows) not in self._mapped:
            self._mapped[name, rows] = getattr(self, name).map(rows)
        return self._mapped[name, rows]


@lru_cache(maxsize=64)
def _ball_functions(joints: tuple[Joint, ...], free: tuple[int, ...]) -> _BallFunctions:
    """Return the functions of a chain; to build them takes longer than most of their calls."""
    return _BallFunctions(joints, free)


def workspace(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Return random joint positions within the joints' limits, shape (count, m) [rad].

    Joints that turn farther stay within -180 to 180 degrees.
    """
    lower = np.array([max(j.lower, -np.pi) for j in robot.actuated])
    upper = np.array([min(j.upper, np.pi) for j in robot.actuated])
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


def gravity_torques(
    robot: Robot,
    positions: np.ndarray,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    payload: float = 0.0,
) -> np.ndarray:
    """Return the torque by which each joint holds the arm against gravity, tau = dU/dq.

    U is the potential energy of the URDF's masses and of a payload at the ball, by the nominal
    model.

    Args:
        robot: The robot.
        positions: Joint positions, shape (N, m).
        gravity: Acceleration in the base frame [m/s^2].
        payload: Mass at the ball's centre [kg].

    Returns:
        Torques [N m] ([N] for a prismatic joint), shape (N, m).
    """
    torque = gravity_function(robot, gravity, payload)
    return torque.map(len(positions))(positions.T).full().T


def gravity_function(
    robot: Robot, gravity: Sequence[float] = STANDARD_GRAVITY, payload: float = 0.0
) -> Any:
    """Return :func:`gravity_torques` as a CasADi function of one configuration."""
    return _gravity_function(robot.joints, robot.bodies, tuple(gravity), payload)


@lru_cache(maxsize=16)
def _gravity_function(
    joints: tuple[Joint, ...], bodies: tuple[Body, ...], gravity: tuple[float, ...], payload: float
) -> Any:
    q = ca.SX.sym("q", sum(joint.actuated for joint in joints))
    origins = [value for joint in joints for value in (*joint.origin.xyz, *joint.origin.rpy)]
    frames = link_frames(joints, ca.DM(origins), q)
    energy: Any = -payload * ca.dot(ca.DM(gravity), frames[-1][1])
    for body in bodies:
        R, p = frames[body.joint]
        energy -= body.mass * ca.dot(ca.DM(gravity), p + R @ ca.DM(body.centre))
    return ca.Function("gravity", [q], [ca.densify(ca.gradient(ca.SX(energy), q))])
