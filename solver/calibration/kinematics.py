"""Kinematics of a calibrated arm with what is on it: its payload, its tool, and its base."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike

from ..results import CalibratedRobot, JointsError, Payload
from ..robot import Goal, Robot, Solutions
from .poses import CommandError, as_poses

Controller = Robot | str | Path | None
"""Model of a controller, or file of its factory calibration; None for the nominal one."""
AT_LIMIT = 1e-9
"""A joint this near to its limit stands at it [rad, m]."""
FARTHEST = 0.1
"""Largest shift of a joint that makes up for what a URDF cannot say [rad, m]."""
MARGIN = 1e-3
"""Positions farther than this outside of the limits are said, since encoders err [rad, m]."""


class Setup(TypedDict, total=False):
    """Setup of the arm, its tool, payload and place; each may be left out, or None."""

    tool: str | ArrayLike | None
    """The tool's pose on the flange, shape (4, 4) [m], or the name of a link of the URDF that
    stands still on it; None for the flange itself, the link that carries the ball."""
    payload: Payload | None
    """Mass [kg], and its centre in the flange's frame [m], as ``(1.2, (0, 0, 0.05))``, beyond the
    masses of the URDF; None for the load of the recordings."""
    base: ArrayLike | None
    """Pose of the robot's base in the frame in which poses are given, shape (4, 4) [m]."""
    frame: str | None
    """Of several robots, in place of ``base``: the frame in which poses are given, as ``right``,
    another's base, or ``right/flange``, see :meth:`.MultiRobotCalibration.base_in`."""
    at: ArrayLike | None
    """Joint positions of that other robot, shape (m,) [rad]."""


@dataclass(frozen=True)
class Kinematics:
    """Forward and inverse kinematics of a calibrated arm's tool, by the full model."""

    arm: CalibratedRobot
    tool: np.ndarray
    """Its pose on the flange, shape (4, 4)."""
    base: np.ndarray
    """Pose of the robot's base in the frame in which poses are given, shape (4, 4)."""

    def pose(self, q: ArrayLike) -> np.ndarray:
        """Return the tool's pose, shape (..., 4, 4), at joint positions of shape (..., m) [rad]."""
        rows, leading = self.rows(q, warn=True)
        return (self.base @ self.arm.poses(rows)[0].reshape(-1, 4, 4) @ self.tool).reshape(
            *leading, 4, 4
        )

    def jacobian(self, q: ArrayLike) -> np.ndarray:
        """Return the tool's geometric Jacobian, shape (..., 6, m): speed, then angular velocity."""
        rows, leading = self.rows(q, warn=True)
        J = self.arm.jacobians(rows, self.tool[:3, 3])[0].reshape(-1, 2, 3, rows.shape[1])
        return (self.base[:3, :3] @ J).reshape(*leading, 6, rows.shape[1])

    def virtual_positions(self, q: ArrayLike) -> np.ndarray:
        """Return positions for ``calibrated.urdf``; see :meth:`.FullModel.virtual_positions`."""
        rows, leading = self.rows(q)
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

    def search(
        self, targets: np.ndarray, goal: Goal, near: ArrayLike | None, prefer: ArrayLike | None
    ) -> Solutions:
        """Return joint positions for what :meth:`targets` returns."""
        start = self.start(near, len(targets), "near")
        wanted = None if prefer is None else self.start(prefer, len(targets), "prefer")
        return self.arm.solver(goal).search(targets, start, wanted, self.tool[:3].ravel())

    def targets(self, pose: ArrayLike) -> tuple[np.ndarray, Goal, tuple[int, ...]]:
        """Return poses in the base frame, as rows of 12; what of them counts; and their shape."""
        T = as_poses(pose, "pose")
        inside = (np.linalg.inv(self.base) @ T)[..., :3, :].reshape(-1, 12)
        return inside, "pose" if np.shape(pose)[-2:] == (4, 4) else "point", T.shape[:-2]

    def start(self, q: ArrayLike | None, count: int, what: str) -> np.ndarray:
        """Return one row of joint positions for each pose; the middle of the ranges for none."""
        robot = self.arm.robot
        endless = ~np.isfinite(robot.upper - robot.lower)
        middle = np.where(endless, 0.0, (robot.lower + robot.upper) / 2)
        start = middle if q is None else q
        rows, _ = self.rows(start, what)
        if len(rows) not in (1, count):
            raise JointsError(
                f"{what} of shape {np.shape(start)} for {count} poses; give them once, or "
                "for each pose"
            )
        return np.broadcast_to(rows, (count, rows.shape[1])).copy()

    def rows(
        self, q: ArrayLike, what: str = "joint positions", *, warn: bool = False
    ) -> tuple[np.ndarray, tuple[int, ...]]:
        """Return joint positions as checked rows, and the shape before the joints'."""
        try:
            array = np.asarray(q, dtype=float)
        except (TypeError, ValueError):
            raise JointsError(f"{what}: {q!r:.60} are no numbers") from None
        rows = array.reshape(-1, array.shape[-1]) if array.ndim > 2 else array
        checked = self.arm.positions(rows, what)
        if warn:
            warn_outside(self.arm.robot, checked)
        return checked, array.shape[:-1]

    def stopped(self, q: np.ndarray) -> str:
        """Return the joint that stands at its limit, empty for none."""
        robot = self.arm.robot
        stopped = (q < robot.lower + AT_LIMIT) | (q > robot.upper - AT_LIMIT)
        return next((name for name, at in zip(robot.joint_names, stopped, strict=True) if at), "")


def warn_outside(robot: Robot, q: np.ndarray) -> None:
    """Say where a joint is outside of its limits."""
    outside = np.argwhere((q < robot.lower - MARGIN) | (q > robot.upper + MARGIN))
    for row, i in outside[:1].tolist():
        warnings.warn(
            f"joint positions: row {row}, {robot.joint_names[i]!r} is {q[row, i]:.4g}, outside its "
            f"limits {robot.lower[i]:.4g} to {robot.upper[i]:.4g}",
            stacklevel=3,
        )
