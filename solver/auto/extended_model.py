"""The ball's place by the extended model: joint origins, and joints that bend and turn unevenly.

The unknowns x are, in this order: the change of each free number of the geometry from nominal,
then the coefficients of each extension. With q' the true joint positions, see
:mod:`mukca.solver.auto.deflection`,

    Phi(x, q) = ball position at origins Theta_nominal + x_geometry and joint positions q'(x, q)
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..robot.kinematics import BallModel, workspace
from ..robot.parameters import Parameter
from ..robot.urdf import Robot
from .deflection import COMPLIANCE, EXTENSIONS, Deflection, coefficient_names, design

__all__ = ["ExtendedModel", "extend"]

SCALE_SAMPLES = 200
"""Random poses from which the scale of a robot is told."""


@dataclass(frozen=True)
class ExtendedModel:
    """A robot whose geometry is free, with some extensions of it."""

    robot: Robot
    parameters: tuple[Parameter, ...]
    ball: BallModel
    """The ball's position as a function of the parameters and the true joint positions."""
    extensions: tuple[str, ...]
    """Among :data:`~mukca.solver.auto.deflection.EXTENSIONS`, in that order."""

    @property
    def geometry(self) -> int:
        """Number of geometric unknowns; those of the extensions follow."""
        return len(self.parameters)

    @property
    def sizes(self) -> list[int]:
        """Number of coefficients of each extension."""
        m = len(self.robot.actuated)
        return [m if extension == COMPLIANCE else 2 * m for extension in self.extensions]

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.geometry + sum(self.sizes)

    @property
    def names(self) -> list[str]:
        """Names of all unknowns."""
        names = [p.name for p in self.parameters]
        for extension in self.extensions:
            names += coefficient_names(extension, self.robot.joint_names)
        return names

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the geometric parameters at some unknowns, shape (geometry,) [m, rad]."""
        return self.ball.nominal + x[: self.geometry]

    def deflection(self, x: np.ndarray) -> Deflection:
        """Return the extensions at some unknowns."""
        ends = self.geometry + np.cumsum(self.sizes)
        values = tuple(x[end - size : end] for end, size in zip(ends, self.sizes, strict=True))
        return Deflection(self.extensions, values)

    def predict(self, x: np.ndarray, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return the ball's centres Phi(x, q), shape (N, 3) [m].

        Args:
            x: The unknowns, shape (size,).
            q: Joint positions as read, shape (N, m).
            torque: Joint torques, shape (N, m) [N m].
        """
        true = self.deflection(x).true_positions(q, torque)
        return self.ball.points(self.values(x), true)

    def linearise(
        self, x: np.ndarray, q: np.ndarray, torque: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return ball centres and their derivatives; arguments as for :meth:`predict`.

        Returns:
            The centres, shape (N, 3) [m]; their derivatives by the unknowns, shape (N, 3, size),
            and by the joint positions, shape (N, 3, m).
        """
        shifts = self._shifts(q, torque)
        true = q + shifts @ x[self.geometry :]
        linear = self.ball.linearise(self.values(x), true)
        by_unknowns = np.concatenate([linear.by_parameters, linear.by_joints @ shifts], axis=2)
        return linear.points, by_unknowns, linear.by_joints

    def by_scale(self) -> np.ndarray:
        """Return the derivative of the logarithm of the robot's scale by the unknowns.

        The scale is the size of the cloud of ball positions in the workspace. Unlike the lengths
        in the model, it does not depend on which of many equivalent descriptions they are.
        """
        q = workspace(self.robot, SCALE_SAMPLES)
        points, slopes, _ = self.linearise(np.zeros(self.size), q, np.zeros_like(q))
        cloud = points - points.mean(axis=0)
        return np.einsum("ni,nij->j", cloud, slopes) / np.sum(cloud**2)

    def _shifts(self, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return how all extensions' coefficients shift the joints, shape (N, m, coefficients)."""
        parts = [design(extension, q, torque) for extension in self.extensions]
        return np.concatenate([np.zeros((*q.shape, 0)), *parts], axis=2)


def extend(
    robot: Robot, parameters: Sequence[Parameter], extensions: Sequence[str] = ()
) -> ExtendedModel:
    """Return the model of a robot with some extensions.

    Args:
        robot: The nominal robot.
        parameters: What of its geometry is free.
        extensions: Among :data:`~mukca.solver.auto.deflection.EXTENSIONS`, in any order.
    """
    ball = BallModel(robot, [p.index for p in parameters])
    ordered = tuple(extension for extension in EXTENSIONS if extension in extensions)
    return ExtendedModel(robot, tuple(parameters), ball, ordered)
