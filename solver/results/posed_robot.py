"""A calibrated robot that poses are asked of: where its flange is, and how joints get there."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..identification.data import Load, Samples
from ..identification.model import Deflection
from ..identification.robot import (
    Robot,
    RowFunction,
    frames_and_motions,
    written_frames,
)
from ..poses import LAST, Goal, PoseModel, PoseSolver, Solutions
from .calibrated import CalibratedRobot


def moments_function(
    robot: Robot,
    gravity: Sequence[float],
    payload: float,
) -> Any:
    """Return :func:`.gravity_moments` as a CasADi function of one configuration."""
    m = len(robot.actuated)
    q = ca.SX.sym("q", m)
    tilts = ca.SX.sym("tilts", 2 * m)
    numbers = ca.vertcat(q, tilts)
    frames = written_frames(robot.joints)
    links, _ = frames_and_motions(robot.joints, frames, numbers)
    _, ball = links[-1]
    down = ca.DM(list(gravity))
    energy: Any = -payload * ca.dot(down, ball)
    for body in robot.bodies:
        R, p = links[body.joint]
        centre = p + R @ ca.DM(body.centre)
        energy -= body.mass * ca.dot(down, centre)
    # Virtual work: a moment is the slope of the energy, here of an arm that does not tilt.
    slopes = ca.gradient(ca.SX(energy), numbers)
    upright = ca.substitute(ca.densify(slopes), tilts, ca.DM.zeros(2 * m))
    return ca.Function("moments", [q], [upright], {"cse": True})


def symbolic_positions(robot: Robot, deflection: Deflection, load: Load, q: Any) -> Any:
    """Return what :meth:`.Deflection.true_positions` computes of numbers, of symbols, shape (n,).

    Args:
        robot: The robot, whose masses load its joints.
        deflection: Elasticity and transmission error of the joints.
        load: Gravity and payload.
        q: Joint positions, shape (m,) [rad].
    """
    moments = moments_function(robot, load.gravity, load.payload)(q)
    rows = [np.array([ca.vertsplit(column)], dtype=object) for column in (q, moments)]
    (positions,) = deflection.true_positions(Samples(*rows))
    return ca.vertcat(*positions)


@dataclass(frozen=True, repr=False)
class PosedRobot(CalibratedRobot):
    """A calibrated robot with the poses of its flange, and their inverse kinematics."""

    @classmethod
    def of(cls, calibrated: CalibratedRobot) -> "PosedRobot":
        """Return a calibrated robot with its poses."""
        if isinstance(calibrated, cls):
            return calibrated
        values: dict[str, Any] = {
            f.name: getattr(calibrated, f.name) for f in fields(calibrated)
        }
        return cls(**values)

    @cached_property
    def pose_model(self) -> PoseModel:
        """The full model as expressions of the joint positions, all its corrections included."""
        origins = self.model.origins(self.values)
        if not self.deflection.extensions:
            return PoseModel.of(self.robot, origins, None)
        correct = partial(symbolic_positions, self.robot, self.deflection, self.load)
        return PoseModel.of(self.robot, origins, correct)

    @cached_property
    def last_step(self) -> float:
        """Largest step of inverse kinematics whose result is not measured [rad].

        Play changes steeply where a joint's load changes sign, so that steps foretell nothing.
        """
        return 0.0 if self.deflection.plays else LAST

    @cached_property
    def solver(self) -> Callable[[Goal], PoseSolver]:
        """Inverse kinematics of the flange for a goal."""
        limits = self.robot.lower, self.robot.upper
        solver = partial(
            PoseSolver, self.pose_model, self.flange, limits, last=self.last_step
        )
        return lru_cache(maxsize=2)(solver)

    @cached_property
    def of_urdf(self) -> PoseSolver:
        """Inverse kinematics of ``calibrated.urdf``; encoders err at its limits, too."""
        endless = np.full(len(self.robot.actuated), np.inf)
        model = PoseModel.of(self.robot, self.origins)
        return PoseSolver(model, self.flange, (-endless, endless))

    @cached_property
    def poses(self) -> RowFunction:
        """Pose of the flange, 16 numbers."""
        model = self.pose_model
        return RowFunction("flange", [model.q], [model.pose(self.flange)])

    @cached_property
    def jacobians(self) -> RowFunction:
        """Jacobian of a point of the flange, 6 m numbers."""
        model = self.pose_model
        point = ca.SX.sym("point", 3)
        R, p = model.frames[self.flange]
        J = model.jacobian(self.flange, p + R @ point)
        return RowFunction("jacobian", [point, model.q], [J])

    def search(
        self,
        goal: Goal,
        targets: np.ndarray,
        near: ArrayLike | None,
        prefer: ArrayLike | None,
        tool: np.ndarray,
    ) -> Solutions:
        """Return joint positions for poses of a tool, shape (N, 12), reached or not.

        ``near`` and ``prefer`` are those of :meth:`.FullModel.command`.
        """
        count = len(targets)
        start = self.starts(near, count, "near")
        posture = None if prefer is None else self.starts(prefer, count, "prefer")
        frame = tool[:3].ravel()
        return self.solver(goal).search(targets, start, posture, frame)
