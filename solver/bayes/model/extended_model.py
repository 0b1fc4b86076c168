"""Predicts the ball from joint origins, elasticity and transmission error together.

The unknowns x are, in this order: the change of each free number of the geometry from nominal,
then the coefficients of each extension. With q' the true joint positions, see
:mod:`mukca.solver.bayes.model.deflection`,

    Phi(x, q) = ball position at origins Theta_nominal + x_geometry and joint positions q'(x, q)
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ...robot import BallModel, Parameter, Robot, workspace
from .deflection import (
    EXTENSIONS,
    PLAY,
    ZERO,
    Deflection,
    backlash,
    coefficient_names,
    deflected,
    design,
)

Expected = tuple[np.ndarray, np.ndarray]
"""What coefficients are believed to be, and the standard deviations of that."""
SCALE_SAMPLES = 200
"""Random poses by which the size of a robot is measured."""


@dataclass(frozen=True)
class ExtendedModel:
    """What is unknown about a robot: numbers of its geometry, and coefficients of extensions."""

    robot: Robot
    parameters: tuple[Parameter, ...]
    ball: BallModel
    """The ball's position as a function of the parameters and the true joint positions."""
    extensions: tuple[str, ...]
    """Which extensions, among :data:`.deflection.EXTENSIONS`, in that order."""
    of_type: Mapping[str, Expected] = field(default_factory=dict[str, Expected])
    """The elasticity of other arms of the type, by extension; empty where none is known."""

    @property
    def geometry(self) -> int:
        """Number of geometric unknowns; those of the extensions follow."""
        return len(self.parameters)

    @cached_property
    def sizes(self) -> list[int]:
        """Number of coefficients of each extension."""
        joints = self.robot.joint_names
        return [len(coefficient_names(extension, joints)) for extension in self.extensions]

    @cached_property
    def size(self) -> int:
        """Number of unknowns."""
        return self.geometry + sum(self.sizes)

    @cached_property
    def names(self) -> list[str]:
        """Names of all unknowns."""
        names = [p.name for p in self.parameters]
        for extension in self.extensions:
            names += coefficient_names(extension, self.robot.joint_names)
        return names

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the free origin numbers for unknowns x, shape (geometry,) [m, rad]."""
        return self.ball.nominal + x[: self.geometry]

    def deflection(self, x: np.ndarray) -> Deflection:
        """Return the elasticity and transmission errors for unknowns x, shape (size,)."""
        ends = self.geometry + np.cumsum(self.sizes)
        values = tuple(x[end - size : end] for end, size in zip(ends, self.sizes, strict=True))
        return Deflection(self.extensions, values)

    def predict(self, x: np.ndarray, q: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Return the ball's centres Phi(x, q), shape (N, 3) [m].

        Args:
            x: The unknowns, shape (size,).
            q: Joint positions as the encoders read them, shape (N, m) [rad].
            torque: What holds the joints, shape (N, 3 m) [N m], see
                :func:`~mukca.solver.robot.kinematics.gravity_moments`; without tilt the torques
                about their own axes are enough, shape (N, m).
        """
        true = self.deflection(x).true_positions(q, torque)
        return self.ball.points(self.values(x), true)

    def linearise(
        self, x: np.ndarray, q: np.ndarray, torque: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return ball centres and their derivatives; arguments as for :meth:`predict`.

        Returns:
            The centres, shape (N, 3) [m]; their derivatives by the unknowns, shape (N, 3, size),
            and by the joint positions, shape (N, 3, m): with play, by as much as each is noisy.
        """
        shifted, shifts = design(self.extensions, q, torque)
        true = deflected(q, shifted, shifts, x[self.geometry :])
        linear = self.ball.linearise(self.values(x), true)
        by_coefficients = linear.by_joints[:, :, shifted] * shifts[:, None]
        by_unknowns = np.concatenate([linear.by_parameters, by_coefficients], axis=2)
        by_joints = linear.by_joints[:, :, : q.shape[1]]
        if PLAY in self.extensions:
            by_joints = by_joints * backlash(torque[:, : q.shape[1]])[:, None]
        return linear.points, by_unknowns, by_joints

    def log_volume(self, x: np.ndarray, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the mean logarithm of the volume that the ball sweeps, and its derivatives.

        The zeros count: lengths and zeros that trade for each other, and leave all balls where they
        are, leave the volume, too. At the readings alone it would grow with such lengths.

        Args:
            x: The unknowns, shape (size,).
            q: Joint positions as the encoders read them, shape (N, m) [rad].

        Returns:
            See :meth:`.BallModel.log_volume`; and the derivatives by the unknowns, shape (size,).
        """
        zeros = self.deflection(x).zeros
        true = q if zeros is None else q + zeros
        value, by_geometry, by_joints = self.ball.log_volume(self.values(x), true)
        slope = np.zeros(self.size)
        slope[: self.geometry] = by_geometry
        if zeros is not None:  # they are the first extension
            slope[self.geometry : self.geometry + len(zeros)] = by_joints
        return value, slope

    def by_scale(self) -> np.ndarray:
        """Return the derivative of the logarithm of the robot's scale by the unknowns.

        The scale is that of the cloud of ball positions over random poses, beside what another
        place of the ball on the flange, or a turn of the base, would do to it: the ball's place
        was only guessed, and says nothing of the arm. One arm can be described by many sets of
        lengths, but its balls are the same in all of them. A zero moves the poses to which
        readings belong, and with them the cloud, but makes no link longer.

        Returns:
            Shape (size,) [1/m, 1/rad, ...]: 0.01 says that one unit more makes the robot 1 %
            larger.
        """
        q = workspace(self.robot, SCALE_SAMPLES)
        points, slopes, _ = self.linearise(np.zeros(self.size), q, np.tile(0 * q, 3))
        cloud = points - points.mean(axis=0)
        of_ball = [i for i, p in enumerate(self.parameters) if p.of_ball and p.unit == "m"]
        place = slopes[:, :, of_ball]
        turns = np.cross(np.eye(3), cloud[:, None]).swapaxes(1, 2)
        others = np.concatenate([place - place.mean(axis=0), turns], axis=2).reshape(cloud.size, -1)
        radial = cloud.ravel() - others @ np.linalg.lstsq(others, cloud.ravel(), rcond=None)[0]
        by_scale = radial @ slopes.reshape(cloud.size, -1) / (radial @ radial)
        if ZERO in self.extensions:
            by_scale[self.geometry : self.geometry + self.sizes[0]] = 0.0
        return by_scale


def extend(
    robot: Robot, parameters: Sequence[Parameter], extensions: Sequence[str] = ()
) -> ExtendedModel:
    """Return the model of a robot with some extensions.

    Args:
        robot: The nominal robot.
        parameters: What of its geometry is free.
        extensions: Among :data:`~mukca.solver.bayes.model.deflection.EXTENSIONS`, in any order.
    """
    ball = BallModel(robot, [p.index for p in parameters])
    ordered = tuple(extension for extension in EXTENSIONS if extension in extensions)
    return ExtendedModel(robot, tuple(parameters), ball, ordered)
