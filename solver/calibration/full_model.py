"""The full model of a calibrated arm as people use it: where it stands, and what to command."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...errors import ON_FLANGE
from ..identification.robot import check_controller, ur_controller
from ..poses import Goal, pose_on_flange
from ..results import CalibratedRobot
from .joint_path import (
    JointPath,
    along,
    check_within,
    find_jumps,
    not_reached,
    reached_rows,
)
from .options import check_keywords
from .poses import (
    HERE,
    Controller,
    PoseError,
    Setup,
    as_poses,
    checked,
    half_way,
    one_payload,
    one_pose,
)
from .sample_model import SampleModel

if TYPE_CHECKING:
    from typing_extensions import Unpack

MOST_HALVINGS = 8
"""Times that parts of a line are halved at most."""


class FullModel(SampleModel):
    """A calibrated robot, with all that was found beyond its geometry, and what it is set up with.

    Args:
        calibrated: The calibrated robot, which carries its payload.
        tool: Pose of the tool on the flange, shape (4, 4) [m].
        base: Pose of the base in the frame in which poses are given, likewise.
    """

    def __init__(
        self,
        calibrated: CalibratedRobot,
        tool: np.ndarray = HERE,
        base: np.ndarray = HERE,
    ) -> None:
        super().__init__(calibrated)
        self.tool, self.base = tool, base
        self._into_base = np.linalg.inv(base)
        self.base_in: Callable[[str, ArrayLike | None], np.ndarray] | None = None
        """Pose of the base in a frame; of robots that were calibrated together."""

    @property
    def nominal(self) -> "FullModel":
        """The nominal robot, for comparisons."""
        return FullModel(self.calibrated.nominal)

    @property
    def geometric(self) -> "FullModel":
        """The robot by ``calibrated.urdf`` alone."""
        return FullModel(self.calibrated.geometric)

    def virtual_positions(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return positions at which ``calibrated.urdf`` has its flange where the full model has it.

        A program that knows the URDF alone is then exact, tilts of the joints included. Positions
        are as the encoders read them, shape (..., m) [rad], given and returned; of the setup a
        payload counts. Where the arm is singular they may be far from q; a row for which there are
        none is NaN.

        Raises:
            CommandError: No row has any: the arm is singular, or has fewer than six joints.
        """
        arm = self.kinematics(**setup).calibrated
        rows = arm.positions(q, stacked=True)
        solutions = arm.of_urdf.solve(arm.poses(rows)[0][:, :12], rows)
        return reached_rows(solutions).reshape(np.shape(q))

    def kinematics(self, **setup: "Unpack[Setup]") -> "FullModel":
        """Return the kinematics of a tool, with a payload and a base, by which all methods compute.

        Raises:
            PoseError: A pose of the setup is none.
            ModelError: No such link, or no such mass.
        """
        if not setup:
            return self
        check_keywords("this method", setup, Setup.__annotations__)
        tool, frame, base = setup.get("tool"), setup.get("frame"), setup.get("base")
        base = self.base if base is None else one_pose(base, "base")
        if frame is not None:
            if self.base_in is None:
                raise PoseError(
                    f"frame {frame!r}: this robot was calibrated alone; give its base there"
                )
            base = base @ self.base_in(frame, setup.get("at"))
        if isinstance(tool, str):
            origins = self.calibrated.model.origins(self.calibrated.values)
            tool = pose_on_flange(self.robot, tool, origins)
        return FullModel(
            self._loaded(one_payload(setup.get("payload"))),
            self.tool if tool is None else one_pose(tool, "tool", ON_FLANGE),
            base,
        )

    def flange(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return the pose of the flange, or of a tool on it, shape (..., 4, 4) [m].

        Args:
            q: Joint positions as the encoders read them, shape (..., m) [rad].
            setup: Tool, payload and base, see :class:`Setup`.

        Raises:
            JointsError: Another number of joints than the robot's, or a number that is no position.
        """
        on = self.kinematics(**setup)
        poses = on.calibrated.poses(checked(on.calibrated, q))[0]
        F = poses.reshape(*np.shape(q)[:-1], 4, 4)
        return on.base @ F @ on.tool

    def jacobian(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return the geometric Jacobian of :meth:`flange`, shape (..., 6, m), likewise.

        For speeds of the joints: that of the tool's origin [m/s], then its angular one [rad/s].
        """
        on = self.kinematics(**setup)
        rows = checked(on.calibrated, q)
        m = rows.shape[1]
        J = on.calibrated.jacobians(rows, on.tool[:3, 3])[0].reshape(-1, 2, 3, m)
        return (on.base[:3, :3] @ J).reshape(*np.shape(q)[:-1], 6, m)

    def command(
        self,
        pose: ArrayLike,
        near: ArrayLike | None = None,
        prefer: ArrayLike | None = None,
        within: float | None = None,
        **setup: "Unpack[Setup]",
    ) -> np.ndarray:
        """Return the joint positions to command, so that the true tool stands at a pose.

        It is the inverse of :meth:`flange`, to 1e-9 m and rad, within the joints' limits. Where
        ``near`` leads nowhere, other starts are tried, and the nearest solution found is returned.

        Args:
            pose: Shape (4, 4), or a point of shape (3,) where the orientation is free [m]; N of
                them in shape (N, 4, 4) or (N, 3).
            near: Joint positions to start from, as those now, shape (m,) or (N, m) [rad]; None for
                the middle of the ranges.
            prefer: Posture to be near where the pose leaves a choice, as of a seventh joint,
                likewise; None for ``near``.
            within: Refuse a solution by which a joint is farther from ``near`` [rad, m], as on
                another branch of the arm; None for any.
            setup: Tool, payload and base, see :class:`Setup`.

        Returns:
            Shape (m,) or (N, m) [rad].

        Raises:
            CommandError: A pose was not reached, or not ``within``; it holds the nearest joint
                positions, what is left, and the joint at its limit.
            PoseError: Numbers that are no pose.
        """
        on = self.kinematics(**setup)
        goal, targets = on.goal(pose)
        solutions = on.calibrated.search(goal, targets, near, prefer, on.tool)
        leading = np.shape(pose)[: -2 if goal == "pose" else -1]
        for row in np.flatnonzero(~solutions.reached)[:1].tolist():
            joint = on.calibrated.stopped(solutions.positions[row])
            where = f"pose {row}" if leading else "pose"
            raise not_reached(where, solutions, row, joint)
        if within is not None:
            arm = on.calibrated
            starts = arm.starts(near, len(targets), "near")
            check_within(solutions, starts, within, arm.robot.joint_names)
        return solutions.positions.reshape(*leading, solutions.positions.shape[1])

    def goal(self, pose: ArrayLike) -> tuple[Goal, np.ndarray]:
        """Return what of the tool's poses counts, and poses in the base as rows of 12."""
        inside = self._into_base @ as_poses(pose, "pose")
        goal: Goal = "pose" if np.shape(pose)[-2:] == (4, 4) else "point"
        return goal, inside[..., :3, :].reshape(-1, 12)

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
        :meth:`.JointPath.checked` refuses poses that are not reached, and jumps.
        """
        on = self.kinematics(**setup)
        arm = on.calibrated
        goal, targets = on.goal(poses)
        search = partial(arm.search, goal, tool=on.tool)
        near = arm.starts(start, 1, "start")
        if start is None and len(targets):
            near = search(targets[:1], near, prefer).positions
        prefer = near if prefer is None else arm.starts(prefer, 1, "prefer")
        solutions = along(search, targets, near, prefer)
        q = solutions.positions
        turns = goal == "pose"
        J = on.jacobian(q)[:, : 6 if turns else 3]
        return JointPath(
            **vars(solutions),
            joint_names=arm.robot.joint_names,
            at_limit=tuple(map(arm.stopped, q)),
            singular_value=np.linalg.svd(J, compute_uv=False).min(axis=1),
            jumps=tuple(find_jumps(q, on.flange, turns)),
        )

    def corrected_pose(
        self,
        pose: ArrayLike,
        near: ArrayLike | None = None,
        prefer: ArrayLike | None = None,
        controller: Controller = None,
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
            controller: The model by which the controller computes; None for the nominal one. Of a
                controller with a factory calibration, a robot loaded from that URDF; of Universal
                Robots', the path of its ``calibration.conf``.
            setup: Tool, payload and base, see :class:`Setup`.

        Returns:
            Shape (..., 4, 4), in the frame of the controller's model's base [m].

        Raises:
            ModelError: A ``calibration.conf`` that is none, or a model of another arm: its flange
                stands 20 mm or more from the nominal one's in the same posture.
        """
        file = controller if isinstance(controller, str | Path) else None
        if isinstance(controller, str | Path):
            controller = ur_controller(self.robot, controller)
        if controller is not None:
            check_controller(self.robot, controller, file)
        believed = CalibratedRobot(controller or self.robot)
        tool = self.kinematics(tool=setup.get("tool")).tool
        return FullModel(believed, tool).flange(
            self.command(pose, near, prefer, **setup)
        )

    def corrected_line(
        self,
        ends: ArrayLike,
        near: ArrayLike,
        tolerance: float = 1e-4,
        controller: Controller = None,
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
            Shape (N, 4, 4), in the frame of the controller's model's base [m].

        Raises:
            CommandError: A pose of the line is not reached, or the joints jump on the way.
        """
        way = as_poses(ends, "ends")
        if way.shape != (2, 4, 4):
            raise PoseError(
                f"ends of shape {np.shape(ends)}: give two poses, shape (2, 4, 4)"
            )
        for _ in range(MOST_HALVINGS):
            q_way = self.command_path(way, near, **setup).checked()
            sent = self.corrected_pose(way, q_way, q_way, controller, **setup)
            middles = half_way(way[:-1], way[1:])
            goals = self.corrected_pose(middles, q_way[:-1], None, controller, **setup)
            offsets = half_way(sent[:-1], sent[1:]) - goals
            bow = np.linalg.norm(offsets[:, :3, 3], axis=1)
            bowed = np.flatnonzero(bow > tolerance)
            if not bowed.size:
                return sent
            way = np.insert(way, bowed + 1, middles[bowed], axis=0)
        within = f"{1e3 * tolerance:.3g} mm"
        raise PoseError(f"ends: no via points keep the line within {within}")
