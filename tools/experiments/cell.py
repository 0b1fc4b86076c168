"""A simulated arm at its table: where it is taught, where it starts, how it is moved."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...solver.robot import Robot
from .controller import ArmModel, ImpedanceController
from .motion import Log, Phase, run
from .postures import elbow_angle, pose_above, reach, self_motion
from .scene import JOINT_FRICTION, Scene, urdf_of

TABLE = 0.08
"""Height of the table above the arm's base [m]."""
READY = np.array([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
"""A Panda's usual posture, elbow up."""
START_ASIDE = 0.02
"""Largest distance of a start to each side of the first goal [m]; as far and more above."""


@dataclass(frozen=True)
class Cell:
    """A true arm, the model that its controller is given, and what stands around it."""

    truth: ArmModel
    """The arm's true kinematics: what hands feel and eyes see. The controller never does."""
    model: ArmModel
    scene: Scene

    def guide(self, point: np.ndarray) -> np.ndarray:
        """Return the configuration that a person guides the arm to: tool upright, elbow up.

        Args:
            point: Where the tip truly is to be, shape (3,) [m].
        """
        return reach(self.truth, READY, pose_above(point))

    def start(
        self, point: np.ndarray, fraction: float, generator: np.random.Generator
    ) -> np.ndarray:
        """Return a configuration from which a trial starts.

        Args:
            point: The tip's first goal, truly, shape (3,) [m]; the start is near and above it.
            fraction: Where in the elbow's range, 0 to 1.
            generator: Source of randomness.
        """
        postures = self_motion(self.truth, self.guide(point), pose_above(point))
        q = postures[int(fraction * len(postures))]
        aside = START_ASIDE * generator.uniform([-1, -1, 0.5], [1, 1, 1.5])
        return reach(self.truth, q, pose_above(point + aside))

    def perform(self, start: np.ndarray, phases: Sequence[Phase]) -> Log:
        """Move the arm from rest at a configuration, shape (m,), through phases of a motion."""
        self.scene.reset(start)
        return run(self.scene, ImpedanceController(self.model), phases)

    def elbow(self, q: np.ndarray) -> float:
        """Return the elbow's angle, zero where it is up [rad]."""
        return elbow_angle(self.truth, q)


def build_cell(
    arm: Robot, urdf: bytes, hole: float | None = None, friction: float = JOINT_FRICTION
) -> Cell:
    """Return a cell.

    Args:
        arm: The arm as it truly is.
        urdf: The model that the controller is given.
        hole: Diameter of the hole [m]; None for a pen on paper.
        friction: Coulomb friction of each joint [N m].
    """
    truth = ArmModel(urdf_of(arm), arm.joint_names, arm.tip)
    model = ArmModel(urdf, arm.joint_names, arm.tip)
    return Cell(truth, model, Scene(arm, table=TABLE, hole=hole, friction=friction))
