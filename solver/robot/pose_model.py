"""The poses of a robot's links, their derivatives and the moments of its weight as expressions.

The kinematics are those of :func:`.link_frames`, at joint positions that a calibration corrects;
the library computes with these CasADi expressions, and exports make code of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .chain import Body, Joint
from .kinematics import across, link_frames, rotation, rotation_rpy
from .row_function import RowFunction
from .urdf import Robot

STANDARD_GRAVITY = (0.0, 0.0, -9.80665)
"""Acceleration in the base frame of an arm that stands upright [m/s^2]."""


@dataclass(frozen=True)
class PoseModel:
    """A robot's model as expressions of its joint positions; each is a column of CasADi's SX."""

    q: Any
    """Joint positions as the encoders read them, shape (m,) [rad]."""
    corrected: Any
    """True positions of the joints, shape (m,) [rad]; their tilts follow where there are any."""
    joints: tuple[Joint, ...]
    """The chain, from the base to the ball."""
    origins: Any
    """Their origins, one after the other, 6 numbers each [m, rad]."""
    frames: tuple[tuple[Any, Any], ...]
    """Rotation and position of each joint's child link in the base frame."""

    @classmethod
    def of(
        cls,
        robot: Robot,
        origins: np.ndarray | None = None,
        correct: Callable[[Any], Any] | None = None,
    ) -> "PoseModel":
        """Return the model of a robot; None for the origins of its URDF, and for a rigid one.

        Origins have shape (joints, 6). ``correct`` makes the true positions of joints that read q,
        and their tilts where there are any.
        """
        q = ca.SX.sym("q", len(robot.actuated))
        true = q if correct is None else correct(q)
        places = ca.DM((robot.origins if origins is None else origins).ravel())
        return cls(q, true, robot.joints, places, tuple(link_frames(robot.joints, places, true)))

    @property
    def true_positions(self) -> Any:
        """True positions of the joints, shape (m,) [rad]."""
        return self.corrected[: self.q.numel()]

    @property
    def ball(self) -> Any:
        """The ball's centre in the base frame, shape (3,) [m]."""
        return ca.densify(self.frames[-1][1])

    def pose(self, joint: int) -> Any:
        """Return the pose of a joint's child link in the base frame, shape (4, 4)."""
        R, p = self.frames[joint]
        return ca.densify(ca.vertcat(ca.horzcat(R, p), ca.DM([[0, 0, 0, 1]])))

    def jacobian(self, joint: int, point: Any = None) -> Any:
        """Return the geometric Jacobian of a joint's child link, shape (6, m).

        It carries the speeds of the joints, as their encoders read them, to the speed of the
        link's origin, or of another point on it [m/s], upper rows, and to its angular velocity
        [rad/s], lower rows; both in the base frame.
        """
        by_corrected = self.by_corrected(joint, self.frames[joint][1] if point is None else point)
        return ca.densify(by_corrected @ ca.jacobian(self.corrected, self.q))

    def by_corrected(self, joint: int, point: Any) -> Any:
        """Return the same by the corrected positions and tilts, shape (6, m) or (6, 3 m).

        Its first m columns are nearly those of :meth:`jacobian`, since joints are corrected by
        milliradians, and take a tenth of the work.
        """
        m, count = self.q.numel(), self.corrected.numel()
        columns = [ca.DM.zeros(6)] * count
        moving, before = 0, ca.DM.eye(3)
        for i, (one, (R, p)) in enumerate(zip(self.joints, self.frames, strict=True)):
            # the same products as in link_frames, so that they are computed once
            upright, before = before @ rotation_rpy(self.origins[6 * i + 3 : 6 * i + 6]), R
            if not one.actuated or i > joint:
                continue
            axes = [upright @ ca.DM(one.axis)]
            if count > m:
                b, c = across(one.axis)
                slides = one.type == "prismatic"
                own = upright if slides else upright @ rotation(one.axis, self.corrected[moving])
                axes += [own @ ca.DM(b), R @ ca.DM(c)]
            for k, along in enumerate(axes):
                slides = k == 0 and one.type == "prismatic"
                turned = ca.vertcat(ca.cross(along, point - p), along)
                columns[k * m + moving] = ca.vertcat(along, ca.DM.zeros(3)) if slides else turned
            moving += 1
        return ca.horzcat(*columns)


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
        then about the first axis :func:`across` each, then about the second.
    """
    rows = _moments_of_rows(robot.joints, robot.bodies, payload)
    return rows(positions, np.array(gravity))[0]


def moments_function(
    robot: Robot, gravity: Sequence[float] = STANDARD_GRAVITY, payload: float = 0.0
) -> Any:
    """Return :func:`gravity_moments` as a CasADi function of one configuration."""
    of_both = _moments_function(robot.joints, robot.bodies, payload)
    q = ca.SX.sym("q", of_both.numel_in(1))
    moments = of_both(ca.DM(list(gravity)), q)
    return ca.Function("moments", [q], [moments], {"cse": True})


@lru_cache(maxsize=16)
def _moments_function(joints: tuple[Joint, ...], bodies: tuple[Body, ...], payload: float) -> Any:
    m = sum(joint.actuated for joint in joints)
    q, tilts = ca.SX.sym("q", m), ca.SX.sym("tilts", 2 * m)
    origins = [value for joint in joints for value in (*joint.origin.xyz, *joint.origin.rpy)]
    frames = link_frames(joints, ca.DM(origins), ca.vertcat(q, tilts))
    gravity = ca.SX.sym("gravity", 3)
    energy: Any = -payload * ca.dot(gravity, frames[-1][1])
    for body in bodies:
        R, p = frames[body.joint]
        energy -= body.mass * ca.dot(gravity, p + R @ ca.DM(body.centre))
    # Virtual work: a moment is the slope of the energy, here of an arm that does not tilt.
    slopes = ca.densify(ca.gradient(ca.SX(energy), ca.vertcat(q, tilts)))
    upright = ca.substitute(slopes, tilts, ca.DM.zeros(2 * m))
    return ca.Function("moments", [gravity, q], [upright], {"cse": True})


@lru_cache(maxsize=16)
def _moments_of_rows(
    joints: tuple[Joint, ...], bodies: tuple[Body, ...], payload: float
) -> RowFunction:
    function = _moments_function(joints, bodies, payload)
    gravity, q = (ca.SX.sym(name, function.numel_in(i)) for i, name in enumerate("gq"))
    return RowFunction("moments", [gravity, q], [function(gravity, q)])
