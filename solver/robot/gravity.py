"""Torques and moments by which the joints of an arm at rest hold it against gravity."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .chain import Body, Joint
from .kinematics import link_frames
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

    They are slopes of the potential energy of the URDF's masses and of a payload at the ball, by
    the nominal model.

    Args:
        robot: The robot.
        positions: Joint positions, shape (N, m).
        gravity: Acceleration in the base frame [m/s^2].
        payload: Mass at the ball's centre [kg].

    Returns:
        Moments [N m] ([N] along a prismatic joint), shape (N, 3 m): about the joints' own axes,
        then about the first axis :func:`across` each, then about the second.
    """
    return _moments_of_rows(robot.joints, robot.bodies, tuple(gravity), payload)(positions)[0]


def moments_function(
    robot: Robot, gravity: Sequence[float] = STANDARD_GRAVITY, payload: float = 0.0
) -> Any:
    """Return :func:`gravity_moments` as a CasADi function of one configuration."""
    return _moments_function(robot.joints, robot.bodies, tuple(gravity), payload)


@lru_cache(maxsize=16)
def _moments_function(
    joints: tuple[Joint, ...], bodies: tuple[Body, ...], gravity: tuple[float, ...], payload: float
) -> Any:
    m = sum(joint.actuated for joint in joints)
    q, tilts = ca.SX.sym("q", m), ca.SX.sym("tilts", 2 * m)
    origins = [value for joint in joints for value in (*joint.origin.xyz, *joint.origin.rpy)]
    frames = link_frames(joints, ca.DM(origins), ca.vertcat(q, tilts))
    energy: Any = -payload * ca.dot(ca.DM(gravity), frames[-1][1])
    for body in bodies:
        R, p = frames[body.joint]
        energy -= body.mass * ca.dot(ca.DM(gravity), p + R @ ca.DM(body.centre))
    # Virtual work: a moment is the slope of the energy, here of an arm that does not tilt.
    slopes = ca.densify(ca.gradient(ca.SX(energy), ca.vertcat(q, tilts)))
    upright = ca.substitute(slopes, tilts, ca.DM.zeros(2 * m))
    return ca.Function("moments", [q], [upright], {"cse": True})


@lru_cache(maxsize=16)
def _moments_of_rows(
    joints: tuple[Joint, ...], bodies: tuple[Body, ...], gravity: tuple[float, ...], payload: float
) -> RowFunction:
    function = _moments_function(joints, bodies, gravity, payload)
    q = ca.SX.sym("q", function.numel_in(0))
    return RowFunction("moments", [q], [function(q)])
