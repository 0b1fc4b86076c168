"""Joint origins, elasticity and transmission error together: true joint positions, and the ball."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate, chain, compress

import numpy as np

from ...robot import BallModel, Parameter, Robot, RotationNumbers, workspace
from .deflection import Deflection, deflected, design_matrix
from .effects import CURVE, EFFECTS, Effect, Readings
from .prior_group import Expected, GivenPrior

SCALE_SAMPLES = 200
"""Random poses by which the size of a robot is measured."""


@dataclass(frozen=True)
class ExtendedModel:
    """Unknowns of a robot: numbers of its geometry, and coefficients of effects beyond it."""

    robot: Robot
    parameters: tuple[Parameter, ...]
    ball: BallModel
    """The ball's position as a function of the parameters and the true joint positions."""
    extensions: tuple[str, ...]
    """Names of the effects, in the order of :data:`.EFFECTS`."""
    of_type: Mapping[str, Expected] = field(default_factory=dict[str, Expected])
    """The elasticity of other arms of the type, by extension; empty where none is known."""
    seen: Collection[str] = ()
    """Coefficients of rare effects that the recordings show, by name; the others are held at 0."""
    given: GivenPrior | None = None
    """Prior of some unknowns, in place of the priors by group."""

    @property
    def geometry(self) -> int:
        """Number of geometric unknowns; those of the extensions follow."""
        return len(self.parameters)

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """The effects beyond the geometry."""
        return tuple(EFFECTS[name] for name in self.extensions)

    @cached_property
    def coefficients(self) -> tuple[list[str], ...]:
        """Names of each effect's coefficients."""
        return tuple(
            effect.coefficient_names(self.robot.joint_names) for effect in self.effects
        )

    @cached_property
    def names(self) -> list[str]:
        """Names of all unknowns."""
        return [
            *(p.name for p in self.parameters),
            *chain.from_iterable(self.coefficients),
        ]

    @cached_property
    def units(self) -> list[str]:
        """Units of all unknowns."""
        units = [p.unit for p in self.parameters]
        for effect, coefficients in zip(self.effects, self.coefficients, strict=True):
            units += [effect.unit] * len(coefficients)
        return units

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Place of each effect's coefficients among the unknowns."""
        bounds = [*accumulate(map(len, self.coefficients), initial=self.geometry)]
        return tuple(map(slice, bounds, bounds[1:]))

    @cached_property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.names)

    @property
    def scalars(self) -> int:
        """Number of unknowns that mean something alone; the coefficients of curves follow."""
        return self.slices[-1].start if CURVE.name in self.extensions else self.size

    def with_effects(self, names: Collection[str]) -> "ExtendedModel":
        """Return the model with the effects of some names in place of its own."""
        return replace(
            self, extensions=tuple(name for name in EFFECTS if name in names)
        )

    @property
    def without_curves(self) -> "ExtendedModel":
        """The model without error curves."""
        return self.with_effects({*self.extensions} - {CURVE.name})

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the free origin numbers for unknowns x, shape (geometry,) [m, rad]."""
        return self.ball.nominal + x[: self.geometry]

    def deflection(self, x: np.ndarray) -> Deflection:
        """Return the elasticity and transmission errors for unknowns x, shape (size,)."""
        return Deflection(self.extensions, tuple(x[members] for members in self.slices))

    def predict(
        self,
        x: np.ndarray,
        q: np.ndarray,
        torque: np.ndarray,
        clocks: np.ndarray | None = None,
    ) -> np.ndarray:
        """Return the ball's centres Phi(x, q), shape (N, 3) [m].

        Args:
            x: The unknowns, shape (size,).
            q: Joint positions as the encoders read them, shape (N, m) [rad].
            torque: What holds the joints, see :func:`~mukca.solver.robot.gravity_moments`, shape
                (N, 3 m) [N m]; without tilt (N, m) is enough.
            clocks: See :class:`.Readings`, shape (N, 3).
        """
        true = self.deflection(x).true_positions(q, torque, clocks)
        return self.ball.points(self.values(x), true)

    def linearise(
        self,
        x: np.ndarray,
        q: np.ndarray,
        torque: np.ndarray,
        clocks: np.ndarray | None = None,
        *,
        of_turns: bool = False,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return ball centres and their derivatives; arguments as for :meth:`predict`.

        Returns:
            The centres, shape (N, 3) [m], or ``of_turns`` the rotations of the ball's link,
            shape (N, 3, 3); their derivatives by the unknowns, shape (N, 3, size), and by the joint
            positions, shape (N, 3, m): with play, by as much as each is noisy.
        """
        turned, turns = design_matrix(self.effects, Readings(q, torque, clocks))
        true = deflected(q, turned, turns, x[self.geometry :])
        function = self.ball.rotations if of_turns else self.ball.linearise
        linear = function(self.values(x), true)
        by_coefficients = linear.by_joints[:, :, turned] * turns[:, None]
        by_unknowns = np.concatenate([linear.by_parameters, by_coefficients], axis=2)
        by_joints = linear.by_joints[:, :, : q.shape[1]]
        for effect in self.effects:
            if effect.joint_noise is not None:
                by_joints = (
                    by_joints * effect.joint_noise(torque[:, : q.shape[1]])[:, None]
                )
        return linear.points, by_unknowns, by_joints

    def log_volume(self, x: np.ndarray, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the mean logarithm of the volume that the ball sweeps, and its slope, (size,).

        The zeros count: lengths and zeros that trade for each other, and leave all balls where they
        are, leave the volume, too. At the readings alone it would grow with such lengths.
        """
        offsets = self.deflection(x).joint_offsets
        true = q if offsets is None else q + offsets
        value, by_geometry, by_joints = self.ball.log_volume(self.values(x), true)
        slope = np.zeros(self.size)
        slope[: self.geometry] = by_geometry
        if offsets is not None:
            slope[self.slices[0]] = by_joints
        return value, slope

    def by_scale(self) -> np.ndarray:
        """Return the derivative of the logarithm of the robot's scale by the unknowns, (size,).

        The scale is that of the cloud of balls over random poses, beside what another place of the
        ball on the flange, a turn of the base, or other zeros and gains of the joints, where these
        are unknown, would do to it. One arm can be described by many sets of lengths, but its balls
        are the same. No zero, gain or curve makes a link longer, nor does an origin that is turned
        about its joint.
        """
        q = workspace(self.robot, SCALE_SAMPLES)
        model = self.without_curves
        points, slopes, _ = model.linearise(np.zeros(model.size), q, np.tile(0 * q, 3))
        cloud = points - points.mean(axis=0)
        columns = [
            i for i, p in enumerate(self.parameters) if p.of_ball and p.unit == "m"
        ]
        for effect, members in zip(model.effects, model.slices, strict=True):
            columns += range(members.start, members.stop) if effect.of_encoder else ()
        shifts = slopes[:, :, columns] - slopes[:, :, columns].mean(axis=0)
        turns = np.cross(np.eye(3), cloud[:, None]).swapaxes(1, 2)
        directions = np.concatenate([shifts, turns], axis=2).reshape(cloud.size, -1)
        no_scale = np.linalg.lstsq(directions, cloud.ravel(), rcond=None)[0]
        radial = cloud.ravel() - directions @ no_scale
        by_scale = radial @ slopes.reshape(cloud.size, -1) / (radial @ radial)
        return np.pad(by_scale, (0, self.size - model.size))


def rare_in(
    coefficients: Mapping[str, Sequence[float]], joints: Sequence[str]
) -> list[str]:
    """Return the names of coefficients of rare effects that are not 0, by those of each effect."""
    names: list[str] = []
    for name, effect in EFFECTS.items():
        if effect.rare:
            names += compress(
                effect.coefficient_names(joints), coefficients.get(name, ())
            )
    return names


def extend(
    robot: Robot,
    parameters: Sequence[Parameter],
    extensions: Sequence[str] = (),
    rotation_numbers: RotationNumbers = "vector",
) -> ExtendedModel:
    """Return the model of a robot with free parameters and some of :data:`.EFFECTS`."""
    ball = BallModel(robot, [p.index for p in parameters], rotation_numbers)
    return ExtendedModel(robot, tuple(parameters), ball, ()).with_effects(extensions)
