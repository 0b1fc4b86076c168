"""Kinematics of a calibrated arm with its tool: where it stands, and how to bring it to a pose."""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..results import CalibratedRobot, JointsError
from ..robot import Goal, Robot, Solutions
from .joint_path import CommandError, JointPath, find_jumps, not_reached
from .loaded_arm import LoadedArm, PoseError, as_poses, half_way

MOST_HALVINGS = 8
"""Times that parts of a line are halved at most."""
FARTHEST = 0.1
"""Largest shift of a joint that makes up for what a URDF cannot say [rad, m]."""
AT_LIMIT = 1e-9
"""A joint this near to its limit stands at it [rad, m]."""
MARGIN = 1e-3
"""Positions farther than this outside of the limits are said, since encoders err [rad, m]."""


@dataclass(frozen=True)
class Kinematics:
    """Forward and inverse kinematics of a calibrated arm's tool, by the full model."""

    arm: LoadedArm
    tool: np.ndarray
    """Its pose on the flange, shape (4, 4)."""
    base: np.ndarray
    """Pose of the robot's base in the frame in which poses are given, shape (4, 4)."""

    def pose(self, q: ArrayLike) -> np.ndarray:
        """Return the tool's pose, shape (..., 4, 4), at joint positions of shape (..., m) [rad]."""
        rows, leading = self._positions(q)
        return (self.base @ self._flanges(rows) @ self.tool).reshape(*leading, 4, 4)

    def jacobian(self, q: ArrayLike) -> np.ndarray:
        """Return the tool's geometric Jacobian, shape (..., 6, m): speed, then angular velocity."""
        rows, leading = self._positions(q)
        J = self.arm.jacobians(rows, self.tool[:3, 3])[0].reshape(len(rows), 2, 3, -1)
        return (self.base[:3, :3] @ J).reshape(*leading, 6, rows.shape[1])

    def command(
        self, pose: ArrayLike, near: ArrayLike | None = None, prefer: ArrayLike | None = None
    ) -> np.ndarray:
        """Return joint positions for poses; see :meth:`.Calibration.command`."""
        targets, goal, leading = self._targets(pose)
        found = self._search(targets, goal, near, prefer)
        if not found.reached.all():
            row = int(np.flatnonzero(~found.reached)[0])
            joint, where = self._stopped(found.positions[row]), f"pose {row}" if leading else "pose"
            words = not_reached(where, found.left[row], joint)
            raise CommandError(words, found.positions[row], found.left[row], joint)
        return found.positions.reshape(*leading, -1)

    def corrected_pose(
        self,
        pose: ArrayLike,
        near: ArrayLike | None = None,
        prefer: ArrayLike | None = None,
        controller: Robot | None = None,
    ) -> np.ndarray:
        """Return the poses to send to a controller; see :meth:`.Calibration.corrected_pose`."""
        sent = controller or self.arm.robot
        believed = LoadedArm(CalibratedRobot(sent, (), np.zeros(0)))
        return Kinematics(believed, self.tool, np.eye(4)).pose(self.command(pose, near, prefer))

    def corrected_line(
        self,
        ends: ArrayLike,
        near: ArrayLike,
        tolerance: float,
        controller: Robot | None = None,
    ) -> np.ndarray:
        """Return via points of a straight line; see :meth:`.Calibration.corrected_line`."""
        way, q = as_poses(ends, "ends"), self._start(near, 1)[0]
        if way.shape != (2, 4, 4):
            raise PoseError(f"ends of shape {np.shape(ends)}: give two poses, shape (2, 4, 4)")
        for _ in range(MOST_HALVINGS):
            q_way = self.command_path(way, q).checked()
            sent = self.corrected_pose(way, q_way, q_way, controller)
            middles = half_way(way[:-1], way[1:])
            wanted = self.corrected_pose(middles, q_way[:-1], q_way[:-1], controller)
            off = np.linalg.norm((half_way(sent[:-1], sent[1:]) - wanted)[:, :3, 3], axis=1)
            bowed = np.flatnonzero(off > tolerance)
            if not bowed.size:
                return sent
            way = np.insert(way, bowed + 1, middles[bowed], axis=0)
        raise PoseError(f"ends: no via points keep the line within {1e3 * tolerance:.3g} mm")

    def virtual_positions(self, q: ArrayLike) -> np.ndarray:
        """Return positions for ``calibrated.urdf``; see :meth:`.Calibration.virtual_positions`."""
        rows, leading = self._rows(q)
        found = self.arm.of_urdf.solve(self.arm.poses(rows)[0][:, :12], rows)
        far = np.abs(found.positions - rows).max(axis=1, initial=0) > FARTHEST
        for row in np.flatnonzero(far | ~found.reached)[:1].tolist():
            raise CommandError(
                f"row {row}: the URDF has no joint positions nearby that put its flange where the "
                f"full model has it, {1e3 * found.left[row, 0]:.3g} mm and "
                f"{1e3 * found.left[row, 1]:.3g} mrad are left: the arm is singular there, or has "
                "fewer than six joints",
                found.positions[row],
                found.left[row],
                "",
            )
        return found.positions.reshape(*leading, -1)

    def command_path(
        self, poses: ArrayLike, start: ArrayLike | None = None, prefer: ArrayLike | None = None
    ) -> JointPath:
        """Return joint positions along poses; see :meth:`.Calibration.command_path`."""
        targets, goal, _ = self._targets(poses)
        near = self._start(start, 1)
        if start is None and len(targets):
            near = self._search(targets[:1], goal, near, prefer).positions
        prefer = near if prefer is None else self._start(prefer, 1)
        rows: list[Solutions] = []
        for target in targets:
            found = self._search(target[None], goal, near, prefer)
            near = found.positions if found.reached.all() else near
            rows.append(found)
        positions, left = (
            np.concatenate([getattr(one, name) for one in rows]) for name in ("positions", "left")
        )
        J = self.jacobian(positions)[:, : 3 if goal == "point" else 6]
        return JointPath(
            joint_names=self.arm.robot.joint_names,
            positions=positions,
            reached=np.concatenate([one.reached for one in rows]),
            left=left,
            rounds=np.concatenate([one.rounds for one in rows]),
            at_limit=tuple(map(self._stopped, positions)),
            singular_value=np.linalg.svd(J, compute_uv=False).min(axis=1),
            jumps=tuple(find_jumps(positions, self.pose, goal == "pose")),
        )

    def _search(
        self, targets: np.ndarray, goal: Goal, near: ArrayLike | None, prefer: ArrayLike | None
    ) -> Solutions:
        start = self._start(near, len(targets))
        wanted = None if prefer is None else self._start(prefer, len(targets))
        return self.arm.solver(goal).search(targets, start, wanted, self.tool[:3].ravel())

    def _targets(self, pose: ArrayLike) -> tuple[np.ndarray, Goal, tuple[int, ...]]:
        """Return poses in the base frame, as rows of 12; what of them counts; and their shape."""
        T = as_poses(pose, "pose")
        inside = (np.linalg.inv(self.base) @ T)[..., :3, :].reshape(-1, 12)
        return inside, "pose" if np.shape(pose)[-2:] == (4, 4) else "point", T.shape[:-2]

    def _start(self, q: ArrayLike | None, count: int) -> np.ndarray:
        """Return one row of joint positions for each pose; the middle of the ranges for none."""
        robot = self.arm.robot
        endless = ~np.isfinite(robot.upper - robot.lower)
        middle = np.where(endless, 0.0, (robot.lower + robot.upper) / 2)
        start = middle if q is None else q
        rows, _ = self._rows(start)
        if len(rows) not in (1, count):
            raise JointsError(
                f"joint positions of shape {np.shape(start)} for {count} poses; give them once, or "
                "for each pose"
            )
        return np.broadcast_to(rows, (count, rows.shape[1])).copy()

    def _rows(self, q: ArrayLike) -> tuple[np.ndarray, tuple[int, ...]]:
        """Return joint positions as checked rows, and the shape before the joints'."""
        array = np.asarray(q)
        rows = array.reshape(-1, array.shape[-1]) if array.ndim > 2 else q
        return self.arm.calibrated.positions(rows), array.shape[:-1]

    def _positions(self, q: ArrayLike) -> tuple[np.ndarray, tuple[int, ...]]:
        """Return the same, and say where a joint is outside of its limits."""
        checked, leading = self._rows(q)
        robot = self.arm.robot
        outside = np.argwhere((checked < robot.lower - MARGIN) | (checked > robot.upper + MARGIN))
        for row, i in outside[:1].tolist():
            warnings.warn(
                f"joint positions: row {row}, {robot.joint_names[i]!r} is {checked[row, i]:.4g}, "
                f"outside its limits {robot.lower[i]:.4g} to {robot.upper[i]:.4g}",
                stacklevel=4,
            )
        return checked, leading

    def _flanges(self, rows: np.ndarray) -> np.ndarray:
        return self.arm.poses(rows)[0].reshape(-1, 4, 4)

    def _stopped(self, q: np.ndarray) -> str:
        robot = self.arm.robot
        stopped = (q < robot.lower + AT_LIMIT) | (q > robot.upper - AT_LIMIT)
        return next((name for name, at in zip(robot.joint_names, stopped, strict=True) if at), "")
