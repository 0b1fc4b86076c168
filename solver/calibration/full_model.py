"""The full model of a calibrated arm as people use it: where it stands, and what to command."""

from functools import lru_cache, partial
from typing import TYPE_CHECKING, TypedDict

import numpy as np
from numpy.typing import ArrayLike

from ..data import Load
from ..results import CalibratedRobot
from ..robot import Robot
from .joint_path import JointPath
from .kinematics import Kinematics
from .loaded_arm import LoadedArm, Payload, one_pose

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Setup(TypedDict, total=False):
    """What is on the arm, and where it stands; each may be left out, or None."""

    tool: str | ArrayLike | None
    """The tool's pose on the flange, shape (4, 4) [m], or the name of a link of the URDF that
    stands still on it; None for the flange itself, the link that carries the ball."""
    payload: Payload | None
    """Mass [kg], and its centre in the flange's frame [m], as ``(1.2, (0, 0, 0.05))``, beyond the
    masses of the URDF; None for the load of the recordings."""
    base: ArrayLike | None
    """Pose of the robot's base in the frame in which poses are given, shape (4, 4) [m]."""


class FullModel:
    """A calibrated robot, with all that was found beyond its geometry.

    Args:
        calibrated: The calibrated robot.
    """

    def __init__(self, calibrated: CalibratedRobot) -> None:
        self.calibrated = calibrated
        """The calibrated robot: predictions and URDFs."""
        self._loaded = lru_cache(maxsize=8)(partial(LoadedArm, calibrated))

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.calibrated.robot

    @property
    def load(self) -> Load:
        """Gravity [m/s^2] and payload at the ball [kg] that it was recorded with."""
        return self.calibrated.load

    def ball(self, q: ArrayLike, effort: ArrayLike | None = None) -> np.ndarray:
        """Return where the calibrated robot has the ball's centre, in its base frame [m].

        Args:
            q: Joint positions in chain order, shape (m,) or (N, m) [rad].
            effort: What the joints exert to hold the arm, of the same shape [N m]; None for the
                gravity torques of the model's masses.

        Returns:
            Shape (3,) or (N, 3).

        Raises:
            JointsError: Another number of joints than the robot's, or a number that is no position.
        """
        return self.calibrated.ball(q, effort)

    def true_positions(self, q: ArrayLike, effort: ArrayLike | None = None) -> np.ndarray:
        """Return where the joints truly are while their encoders read q [rad].

        Args, shapes and errors are those of :meth:`ball`; shape (m,) or (N, m).
        """
        return self.calibrated.true_positions(q, effort)

    def virtual_positions(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return positions at which ``calibrated.urdf`` has its flange where the full model has it.

        A program that knows the URDF alone is then exact, tilts of the joints included.

        Args:
            q: Joint positions as the encoders read them, shape (..., m) [rad].
            setup: A payload, see :class:`Setup`.

        Returns:
            Of the same shape; some milliradians off q.

        Raises:
            CommandError: There are none nearby: the arm is singular, or has fewer than six joints.
            JointsError: See :meth:`flange`.
        """
        return self.kinematics(**setup).virtual_positions(q)

    def kinematics(self, **setup: "Unpack[Setup]") -> Kinematics:
        """Return forward and inverse kinematics with a tool; the methods below are its own.

        Args:
            setup: Tool, payload and base, see :class:`Setup`.

        Raises:
            PoseError: A pose is none.
            ModelError: No such link, or no such mass.
        """
        payload, base = setup.get("payload"), setup.get("base")
        arm = self._loaded(payload and (float(payload[0]), tuple(map(float, payload[1]))))
        where = np.eye(4) if base is None else one_pose(base, "base")
        return Kinematics(arm, arm.tool(setup.get("tool")), where)

    def flange(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return the pose of the flange, or of a tool on it, shape (..., 4, 4) [m].

        Args:
            q: Joint positions as the encoders read them, shape (..., m) [rad].
            setup: Tool, payload and base, see :class:`Setup`.

        Raises:
            JointsError: Another number of joints than the robot's, or a number that is no position.
        """
        return self.kinematics(**setup).pose(q)

    def jacobian(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return the geometric Jacobian of :meth:`flange`, whose arguments and errors it has.

        Returns:
            Shape (..., 6, m): for speeds of the joints, the speed of the tool's origin [m/s], and
            below it the angular velocity [rad/s].
        """
        return self.kinematics(**setup).jacobian(q)

    def command(
        self,
        pose: ArrayLike,
        near: ArrayLike | None = None,
        prefer: ArrayLike | None = None,
        **setup: "Unpack[Setup]",
    ) -> np.ndarray:
        """Return the joint positions to command, so that the true tool stands at a pose.

        It is the inverse of :meth:`flange`, to 1e-10 m and rad, within the joints' limits. Where
        ``near`` leads nowhere, other starts are tried, and the nearest solution found is returned.

        Args:
            pose: Shape (4, 4), or a point of shape (3,) where the orientation is free [m]; N of
                them in shape (N, 4, 4) or (N, 3).
            near: Joint positions to start from, as those now, shape (m,) or (N, m) [rad]; None for
                the middle of the ranges.
            prefer: Posture to be near where the pose leaves a choice, as of a seventh joint,
                likewise; None for ``near``.
            setup: Tool, payload and base, see :class:`Setup`.

        Returns:
            Shape (m,) or (N, m) [rad].

        Raises:
            CommandError: A pose was not reached; it holds the nearest joint positions, what is
                left, and the joint at its limit.
            PoseError: Numbers that are no pose.
            JointsError: See :meth:`flange`.
        """
        return self.kinematics(**setup).command(pose, near, prefer)

    def command_path(
        self,
        poses: ArrayLike,
        start: ArrayLike | None = None,
        prefer: ArrayLike | None = None,
        **setup: "Unpack[Setup]",
    ) -> JointPath:
        """Return the joint positions to command along poses, each near those before.

        Arguments are those of :meth:`command`, with ``start`` the joint positions before the first
        pose; None for any that reach it. A redundant arm stays near ``prefer``, by default near
        ``start``, so that a closed path of the tool is a closed one of the joints.

        Returns:
            A table; its :meth:`.JointPath.checked` refuses poses that are not reached, and jumps.

        Raises:
            PoseError: Numbers that are no pose.
            JointsError: See :meth:`flange`.
        """
        return self.kinematics(**setup).command_path(poses, start, prefer)

    def corrected_pose(
        self,
        pose: ArrayLike,
        near: ArrayLike | None = None,
        prefer: ArrayLike | None = None,
        controller: Robot | None = None,
        **setup: "Unpack[Setup]",
    ) -> np.ndarray:
        """Return the pose to send to a Cartesian controller, so that the true tool stands at one.

        It is where the controller believes the tool to be at the positions of :meth:`command`. With
        six joints that is all; a seventh is the controller's choice: read the joints back when it
        has arrived, give them as ``near``, and send once more.

        Args:
            pose: See :meth:`command`,
            near: and there,
            prefer: and there.
            controller: The model by which the controller computes; None for the nominal one. A
                controller with a factory calibration has its own: load that URDF.
            setup: Tool, payload and base, see :class:`Setup`.

        Returns:
            Shape (..., 4, 4), in the frame of the robot's base [m].

        Raises:
            CommandError: See :meth:`command`.
        """
        return self.kinematics(**setup).corrected_pose(pose, near, prefer, controller)

    def corrected_line(
        self,
        ends: ArrayLike,
        near: ArrayLike,
        tolerance: float = 1e-4,
        controller: Robot | None = None,
        **setup: "Unpack[Setup]",
    ) -> np.ndarray:
        """Return the poses to send one after the other, so that the true tool goes straight.

        Between two corrected poses a controller's straight line bows, since its error changes on
        the way; each part is halved until it bows by less than the tolerance.

        Args:
            ends: The first and the last pose of the tool, shape (2, 4, 4) [m].
            near: Joint positions at the beginning, shape (m,) [rad].
            tolerance: Largest distance from the line half way between two poses sent [m].
            controller: See :meth:`corrected_pose`.
            setup: Tool, payload and base, see :class:`Setup`.

        Returns:
            Shape (N, 4, 4), in the frame of the robot's base [m].

        Raises:
            CommandError: A pose of the line is not reached, or the joints jump on the way.
        """
        return self.kinematics(**setup).corrected_line(ends, near, tolerance, controller)
