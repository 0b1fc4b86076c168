"""The moments by which joints hold an arm's masses against gravity."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .bodies import Body
from .chain import Joint
from .kinematics import frames_and_motions, written_frames
from .row_function import RowFunction
from .urdf import Robot

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
"""Acceleration in the base frame of an arm that stands upright [m/s^2]."""


def gravity_moments(
    robot: Robot,
    positions: np.ndarray,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    payload: float = 0.0,
) -> np.ndarray:
    """Return the moments by which each joint holds the arm against gravity, about its three axes.

    They are slopes of the potential energy of the URDF's masses and of a payload [kg] at the ball,
    by the nominal model at joint positions of shape (N, m), with gravity in the base frame [m/s^2].

    Returns:
        Moments [N m] ([N] along a prismatic joint), shape (N, 3 m): about the joints' own axes,
        then about the first of each one's :attr:`.Joint.tilt_axes`, then about the second.
    """
    rows = np.ascontiguousarray(positions, dtype=float)
    moments = _moments_at(
        robot.joints, robot.bodies, payload, tuple(gravity), rows.shape, rows.tobytes()
    )
    return moments.copy()


@lru_cache(maxsize=16)
def _moments_at(
    joints: tuple[Joint, ...],
    bodies: tuple[Body, ...],
    payload: float,
    gravity: tuple[float, ...],
    shape: tuple[int, ...],
    positions: bytes,
) -> np.ndarray:
    """Return the moments at joint positions, which are asked for of the same samples in turn."""
    rows = np.frombuffer(positions).reshape(shape)
    [moments] = _moments(joints, bodies, payload)(rows, np.array(gravity))
    return moments


def moments_function(
    robot: Robot,
    gravity: Sequence[float] = STANDARD_GRAVITY,
    payload: float = 0.0,
) -> Any:
    """Return :func:`gravity_moments` as a CasADi function of one configuration."""
    of_both = _moments(robot.joints, robot.bodies, payload).function
    q = ca.SX.sym("q", of_both.numel_in(1))
    moments = of_both(ca.DM(list(gravity)), q).T
    return ca.Function("moments", [q], [moments], {"cse": True})


@lru_cache(maxsize=16)
def _moments(
    joints: tuple[Joint, ...],
    bodies: tuple[Body, ...],
    payload: float,
) -> RowFunction:
    """Return the moments as a function of gravity and joint positions."""
    m = sum(joint.actuated for joint in joints)
    q = ca.SX.sym("q", m)
    tilts = ca.SX.sym("tilts", 2 * m)
    numbers = ca.vertcat(q, tilts)
    gravity = ca.SX.sym("gravity", 3)
    links, _, _ = frames_and_motions(joints, written_frames(joints), numbers)
    _, ball = links[-1]
    energy: Any = -payload * ca.dot(gravity, ball)
    for body in bodies:
        R, p = links[body.joint]
        centre = p + R @ ca.DM(body.centre)
        energy -= body.mass * ca.dot(gravity, centre)
    # Virtual work: a moment is the slope of the energy, here of an arm that does not tilt.
    slopes = ca.gradient(ca.SX(energy), numbers)
    upright = ca.substitute(ca.densify(slopes), tilts, ca.DM.zeros(2 * m))
    return RowFunction("moments", [gravity, q], [upright])
