"""The position of the ball as a function of the parameters and the joint positions.

There is one forward kinematics, :func:`ball_position`, written once as a CasADi expression.
The transform over joint i is, with its origin (p, rpy), its axis a and its position q,

    T(i-1, i) = [ R(rpy) R(a, q) | p ]            revolute, continuous (Rodrigues' formula)
    T(i-1, i) = [ R(rpy)         | p + R(rpy) a q ]   prismatic

with R(rpy) = Rz(yaw) Ry(pitch) Rx(roll), the convention of URDF.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .urdf import Body, Joint, Robot

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


def rotation(axis: Sequence[float], angle: Any) -> Any:
    """Return the rotation about a unit axis, Rodrigues' formula: I + sin K + (1 - cos) K^2."""
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
        origins: Their origins, one after the other: x y z roll pitch yaw each.
        q: Positions of those that move, in order.
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
    """The ball positions of N samples, and their first derivatives."""

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
        free: Indices of the free numbers among the chain's origins, 6 a joint, in the order of
            ``chain.origins.ravel()``; all others stay as the model has them.
    """

    def __init__(self, robot: Robot, free: Sequence[int]) -> None:
        self.robot = robot
        self.free = np.array(free, dtype=int)
        self.nominal: np.ndarray = robot.origins.ravel()[self.free]
        x, q = ca.SX.sym("x", len(self.free)), ca.SX.sym("q", len(robot.actuated))
        origins = ca.SX(robot.origins.ravel())
        origins[self.free.tolist()] = x
        p = ball_position(robot.joints, origins, q)
        self.function = ca.Function("ball", [x, q], [p], ["x", "q"], ["p"])
        self._linear = ca.Function(
            "ball_linear",
            [x, q],
            [p, ca.densify(ca.jacobian(p, x)), ca.densify(ca.jacobian(p, q))],
            {"cse": True},
        )
        self._mapped: dict[tuple[str, int], Any] = {}

    def origins(self, parameters: np.ndarray) -> np.ndarray:
        """Return all origins with the free numbers in place, shape (joints, 6)."""
        origins = self.robot.origins.ravel()
        origins[self.free] = parameters
        return origins.reshape(-1, 6)

    def points(self, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Return the ball's centre for each row of joint positions, shape (N, 3) [m]."""
        result = self._map(self.function, len(positions))(parameters, positions.T)
        return result.full().T

    def linearise(self, parameters: np.ndarray, positions: np.ndarray) -> Linearisation:
        """Return the ball's centres and their derivatives for each row of joint positions."""
        N, n, m = len(positions), len(self.free), positions.shape[1]
        p, by_x, by_q = self._map(self._linear, N)(parameters, positions.T)
        return Linearisation(
            p.full().T,
            by_x.full().T.reshape(N, n, 3).transpose(0, 2, 1),
            by_q.full().T.reshape(N, m, 3).transpose(0, 2, 1),
        )

    def _map(self, function: Any, N: int) -> Any:
        """Return a function mapped over N samples, built once for each N."""
        key = (function.name(), N)
        if key not in self._mapped:
            self._mapped[key] = function.map(N)
        return self._mapped[key]


def workspace(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Return random joint positions within the limits, and within one turn, shape (count, m)."""
    lower = np.array([max(j.lower, -np.pi) for j in robot.actuated])
    upper = np.array([min(j.upper, np.pi) for j in robot.actuated])
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


def gravity_torques(
    robot: Robot,
    positions: np.ndarray,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    payload: float = 0.0,
) -> np.ndarray:
    """Return what each joint exerts on the arm to hold it at rest, tau = dU/dq.

    U is the potential energy of the chain's masses, and of a payload at the ball, by the
    nominal model.

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
