"""The full model of a calibrated arm as people use it: where it stands, and what to command."""

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..data import Load
from ..results import CalibratedRobot
from ..robot import Robot, Solutions, pose_on_flange, ur_controller
from .kinematics import Controller, Kinematics, Setup, warn_outside
from .options import check_keywords
from .poses import JointPath, PoseError, as_poses, find_jumps, half_way, not_reached, one_pose

if TYPE_CHECKING:
    from typing_extensions import Unpack

MOST_HALVINGS = 8
"""Times that parts of a line are halved at most."""


def _alone(frame: str, _: ArrayLike | None) -> np.ndarray:
    raise PoseError(f"frame {frame!r}: this robot was calibrated alone; give its base there")


class FullModel:
    """A calibrated robot, with all that was found beyond its geometry."""

    def __init__(self, calibrated: CalibratedRobot) -> None:
        self.calibrated = calibrated
        """The calibrated robot: predictions and URDFs."""
        self.base_in: Callable[[str, ArrayLike | None], np.ndarray] = _alone
        """Pose of the base in a frame; of robots that were calibrated together."""
        self._loaded = lru_cache(maxsize=8)(calibrated.carrying)

    @property
    def robot(self) -> Robot:
        """The nominal robot."""
        return self.calibrated.robot

    @property
    def load(self) -> Load:
        """Gravity [m/s^2] and payload at the ball [kg] that it was recorded with."""
        return self.calibrated.load

    @property
    def nominal(self) -> "FullModel":
        """The nominal robot, for comparisons."""
        return FullModel(CalibratedRobot(self.robot, (), np.zeros(0)))

    @property
    def geometric(self) -> "FullModel":
        """The robot by ``calibrated.urdf`` alone."""
        return FullModel(self.calibrated.geometric)

    def ball(self, q: ArrayLike, effort: ArrayLike | None = None) -> np.ndarray:
        """Return where the calibrated robot has the ball's centre, in its base frame [m].

        Args and errors are those of :meth:`.CalibratedRobot.ball`.
        """
        found = self.calibrated.ball(q, effort)
        warn_outside(self.robot, self.calibrated.positions(q))
        return found

    def true_positions(self, q: ArrayLike, effort: ArrayLike | None = None) -> np.ndarray:
        """Return where the joints truly are while their encoders read q [rad].

        Args, shapes and errors are those of :meth:`ball`; shape (m,) or (N, m).
        """
        found = self.calibrated.true_positions(q, effort)
        warn_outside(self.robot, self.calibrated.positions(q))
        return found

    def virtual_positions(self, q: ArrayLike, **setup: "Unpack[Setup]") -> np.ndarray:
        """Return positions at which ``calibrated.urdf`` has its flange where the full model has it.

        A program that knows the URDF alone is then exact, tilts of the joints included. Positions
        are as the encoders read them, shape (..., m) [rad], given and returned; of the setup a
        payload counts.

        Raises:
            CommandError: There are none nearby: the arm is singular, or has fewer than six joints.
        """
        return self.kinematics(**setup).virtual_positions(q)

    def kinematics(self, **setup: "Unpack[Setup]") -> Kinematics:
        """Return the kinematics of a tool, by which the methods below compute.

        Raises:
            PoseError: A pose of the setup is none.
            ModelError: No such link, or no such mass.
        """
        check_keywords("this method", setup, Setup.__annotations__)
        tool, payload, frame = setup.get("tool"), setup.get("payload"), setup.get("frame")
        base = setup.get("base") if frame is None else self.base_in(frame, setup.get("at"))
        if isinstance(tool, str):
            origins = self.calibrated.model.origins(self.calibrated.values)
            tool = pose_on_flange(self.robot, tool, origins)
        where, there = (
            np.eye(4) if pose is None else one_pose(pose, word)
            for pose, word in ((tool, "tool"), (base, "base"))
        )
        try:
            loaded = None if payload is None else (float(payload[0]), tuple(map(float, payload[1])))
        except (TypeError, ValueError, IndexError):
            raise PoseError(
                f"payload {payload!r:.60}: give its mass and its centre, as (1.2, (0, 0, 0.05))"
            ) from None
        return Kinematics(self._loaded(loaded), where, there)

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
        """Return the geometric Jacobian of :meth:`flange`, shape (..., 6, m), likewise.

        For speeds of the joints: that of the tool's origin [m/s], then its angular one [rad/s].
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

        It is the inverse of :meth:`flange`, to 1e-9 m and rad, within the joints' limits. Where
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
        """
        on = self.kinematics(**setup)
        targets, goal, leading = on.targets(pose)
        found = on.search(targets, goal, near, prefer)
        if not found.reached.all():
            row = int(np.flatnonzero(~found.reached)[0])
            joint, where = on.stopped(found.positions[row]), f"pose {row}" if leading else "pose"
            raise not_reached(where, found.positions[row], found.left[row], joint)
        return found.positions.reshape(*leading, found.positions.shape[1])

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
        targets, goal, _ = on.targets(poses)
        near = on.start(start, 1, "start")
        if start is None and len(targets):
            near = on.search(targets[:1], goal, near, prefer).positions
        prefer = near if prefer is None else on.start(prefer, 1, "prefer")
        rows: list[Solutions] = []
        for target in targets:
            found = on.search(target[None], goal, near, prefer)
            near = found.positions if found.reached.all() else near
            rows.append(found)
        rows = rows or [on.search(targets, goal, near, prefer)]
        positions, left = (
            np.concatenate([getattr(one, name) for one in rows]) for name in ("positions", "left")
        )
        J = on.jacobian(positions)[:, : 3 if goal == "point" else 6]
        return JointPath(
            joint_names=on.arm.robot.joint_names,
            positions=positions,
            reached=np.concatenate([one.reached for one in rows]),
            left=left,
            rounds=np.concatenate([one.rounds for one in rows]),
            at_limit=tuple(map(on.stopped, positions)),
            singular_value=np.linalg.svd(J, compute_uv=False).min(axis=1),
            jumps=tuple(find_jumps(positions, on.pose, goal == "pose")),
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
            ModelError: A ``calibration.conf`` that is none, or not of this type of arm.
        """
        if isinstance(controller, str | Path):
            controller = ur_controller(self.robot, controller)
        believed = FullModel(CalibratedRobot(controller or self.robot, (), np.zeros(0)))
        tool = self.kinematics(tool=setup.get("tool")).tool
        return believed.flange(self.command(pose, near, prefer, **setup), tool=tool)

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
        way, q = as_poses(ends, "ends"), near
        if way.shape != (2, 4, 4):
            raise PoseError(f"ends of shape {np.shape(ends)}: give two poses, shape (2, 4, 4)")
        for _ in range(MOST_HALVINGS):
            q_way = self.command_path(way, q, **setup).checked()
            sent = self.corrected_pose(way, q_way, q_way, controller, **setup)
            middles = half_way(way[:-1], way[1:])
            wanted = self.corrected_pose(middles, q_way[:-1], None, controller, **setup)
            off = np.linalg.norm((half_way(sent[:-1], sent[1:]) - wanted)[:, :3, 3], axis=1)
            bowed = np.flatnonzero(off > tolerance)
            if not bowed.size:
                return sent
            way = np.insert(way, bowed + 1, middles[bowed], axis=0)
        raise PoseError(f"ends: no via points keep the line within {1e3 * tolerance:.3g} mm")
