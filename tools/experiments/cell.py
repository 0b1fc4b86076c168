"""A simulated arm at its table: where it is taught, where it starts, how it is moved."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from ...solver.robot import Robot
from .controller import WINDOW, ArmModel, ImpedanceController, Pose
from .motion import Log, Phase, elbow_angle, hold, move, pose_above, reach, run, self_motion
from .results import Insertion, Retracing
from .scene import Scene, urdf_of

READY = np.array([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
"""A Panda's usual posture, elbow up."""
START_ASIDE = 0.02
"""Largest distance of a start to each side of the first goal [m]; as far and more above."""
Result = TypeVar("Result", Insertion, Retracing)


@dataclass(frozen=True)
class Trial(Generic[Result]):
    """One trial: the motion, and what came of it."""

    log: Log
    result: Result


class Cell:
    """A true arm, the model that its controller is given, and the table; hole in metres."""

    def __init__(self, arm: Robot, urdf: bytes, hole: float | None = None) -> None:
        # The arm's true kinematics: what hands feel and eyes see. The controller never does.
        self.truth = ArmModel(urdf_of(arm), arm.joint_names, arm.tip)
        self.model = ArmModel(urdf, arm.joint_names, arm.tip)
        self.scene = Scene(arm, hole)

    def guide(self, point: np.ndarray) -> np.ndarray:
        """Return the configuration, tool upright and elbow up, that puts the true tip there."""
        return reach(self.truth, READY, pose_above(point))

    def start(
        self, point: np.ndarray, fraction: float, generator: np.random.Generator
    ) -> np.ndarray:
        """Return a configuration near and above a point, from 0 to 1 of the elbow's range."""
        postures = self_motion(self.truth, self.guide(point), pose_above(point))
        q = postures[int(fraction * len(postures))]
        aside = START_ASIDE * generator.uniform([-1, -1, 0.5], [1, 1, 1.5])
        return reach(self.truth, q, pose_above(point + aside))

    def perform(
        self, start: np.ndarray, goal: Pose, then: Sequence[Phase], touching: Sequence[str]
    ) -> tuple[Log, dict[str, float]]:
        """Go from rest to a goal, let the compensator remove the offset, and go on without it.

        Returned are the log, and the fields of :class:`Motion`, forces from the touching phases.
        """
        self.scene.reset(start)
        phases = [
            move("approach", 3.0, self.model.pose(start), goal),
            hold("compensate", WINDOW, goal, compensate=True),
            *then,
        ]
        log = run(self.scene, ImpedanceController(self.model), phases)
        forces = log.forces(*touching)
        return log, {
            "elbow": elbow_angle(self.truth, start),
            "force": float(forces.mean()),
            "peak_force": float(forces.max()),
        }
