"""Joint origins, elasticity and transmission error together: true joint positions, and the ball."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate, chain, compress
from typing import NamedTuple

import numpy as np

from ..data import Samples
from ..effects import CURVE, EFFECTS, Effect
from ..robot import BallModel, Parameter, Robot, RotationNumbers, workspace
from .deflection import Deflection, design_matrix
from .prior_group import GivenPrior

SCALE_SAMPLES = 200
"""Random poses by which the size of a robot is measured."""


class Prediction(NamedTuple):
    """N predicted balls, or rotations of their links, and their derivatives."""

    points: np.ndarray
    """Centres, shape (N, 3) [m], or rotations, shape (N, 3, 3)."""
    by_unknowns: np.ndarray
    """Shape (N, 3, size); of a rotation, turns about the base's axes."""
    by_joints: np.ndarray
    """By the joint positions, shape (N, 3, m): with play, by as much as each is noisy."""


@dataclass(frozen=True)
class ExtendedModel:
    """Unknowns of a robot: numbers of its geometry, and coefficients of effects beyond it."""

    robot: Robot
    parameters: tuple[Parameter, ...]
    ball: BallModel
    """The ball's position as a function of the parameters and the true joint positions."""
    extensions: tuple[str, ...]
    """Names of the effects, in the order of :data:`.EFFECTS`."""
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
        joints = self.robot.joint_names
        return tuple(effect.coefficient_names(joints) for effect in self.effects)

    @cached_property
    def names(self) -> list[str]:
        """Names of all unknowns."""
        names = [p.name for p in self.parameters]
        return [*names, *chain(*self.coefficients)]

    @cached_property
    def units(self) -> list[str]:
        """Units of all unknowns."""
        units = [p.unit for p in self.parameters]
        for k, effect in enumerate(self.effects):
            count = len(self.coefficients[k])
            units += count * [effect.unit]
        return units

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Place of each effect's coefficients among the unknowns."""
        counts = map(len, self.coefficients)
        bounds = [*accumulate(counts, initial=self.geometry)]
        return tuple(map(slice, bounds, bounds[1:]))

    @cached_property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.names)

    @property
    def scalars(self) -> int:
        """Number of unknowns that mean something alone; the coefficients of curves follow."""
        if CURVE.name not in self.extensions:
            return self.size
        return self.slices[-1].start

    def with_effects(self, names: Collection[str]) -> "ExtendedModel":
        """Return the model with the effects of some names in place of its own."""
        extensions = tuple(name for name in EFFECTS if name in names)
        return replace(self, extensions=extensions)

    @property
    def without_curves(self) -> "ExtendedModel":
        """The model without error curves."""
        return self.with_effects({*self.extensions} - {CURVE.name})

    def values(self, x: np.ndarray) -> np.ndarray:
        """Return the free origin numbers for unknowns x, shape (geometry,) [m, rad]."""
        return self.ball.nominal + x[: self.geometry]

    def deflection(self, x: np.ndarray) -> Deflection:
        """Return the elasticity and transmission errors for unknowns x, shape (size,)."""
        coefficients = tuple(x[place] for place in self.slices)
        return Deflection(self.extensions, coefficients)

    def predict(self, x: np.ndarray, samples: Samples) -> np.ndarray:
        """Return the ball's centres Phi(x, q), shape (N, 3) [m].

        ``x`` are the unknowns, shape (size,), and any others behind them.
        """
        true = self.deflection(x).true_positions(samples)
        return self.ball.points(self.values(x), true)

    def linearise(
        self,
        x: np.ndarray,
        samples: Samples,
        *,
        of_turns: bool = False,
    ) -> Prediction:
        """Return ball centres and their derivatives; arguments as for :meth:`predict`.

        ``of_turns`` returns the rotations of the ball's link in their place.
        """
        design = design_matrix(self.effects, samples)
        coefficients = x[self.geometry : self.size]
        true = design.true_positions(samples.q, coefficients)
        function = self.ball.rotations if of_turns else self.ball.linearise
        linear = function(self.values(x), true)
        by_axes = linear.by_joints[:, :, design.axes]
        by_coefficients = by_axes * design.turns[:, None]
        parts = linear.by_parameters, by_coefficients
        by_unknowns = np.concatenate(parts, axis=2)
        m = samples.q.shape[1]
        by_joints = linear.by_joints[:, :, :m]
        for effect in self.effects:
            if effect.joint_noise is not None:
                shares = effect.joint_noise(samples.torques)
                by_joints = by_joints * shares[:, None]
        return Prediction(linear.points, by_unknowns, by_joints)

    def log_volume(self, x: np.ndarray, q: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the mean logarithm of the volume that the ball sweeps, and its slope, (size,).

        The zeros count: lengths and zeros that trade for each other, and leave all balls where they
        are, leave the volume, too. At the readings alone it would grow with such lengths.
        """
        offsets = self.deflection(x).joint_offsets
        true = q if offsets is None else q + offsets
        values = self.values(x)
        log_volume, by_geometry, by_joints = self.ball.log_volume(values, true)
        slope = np.zeros(self.size)
        slope[: self.geometry] = by_geometry
        if offsets is not None:
            slope[self.slices[0]] = by_joints
        return log_volume, slope

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
        nominal = np.zeros(model.size)
        balls = model.linearise(nominal, Samples.unloaded(q))
        cloud = balls.points - balls.points.mean(axis=0)
        J = balls.by_unknowns.reshape(cloud.size, -1)
        shifts = balls.by_unknowns[:, :, model.scaleless]
        shifts = shifts - shifts.mean(axis=0)
        turns = np.cross(np.eye(3), cloud[:, None])
        turns = turns.swapaxes(1, 2)
        directions = np.concatenate([shifts, turns], axis=2)
        directions = directions.reshape(cloud.size, -1)
        places = cloud.ravel()
        sizes = np.linalg.lstsq(directions, places, rcond=None)[0]
        radial = places - directions @ sizes
        by_scale = radial @ J / (radial @ radial)
        of_curves = self.size - model.size
        return np.pad(by_scale, (0, of_curves))

    @property
    def scaleless(self) -> list[int]:
        """Indices of the ball's place on the flange, and of zeros and gains of the encoders."""
        indices: list[int] = []
        for i, parameter in enumerate(self.parameters):
            if parameter.of_ball and parameter.unit == "m":
                indices.append(i)
        for effect, place in zip(self.effects, self.slices, strict=True):
            if effect.of_encoder:
                indices += range(place.start, place.stop)
        return indices


def rare_in(
    coefficients: Mapping[str, Sequence[float]],
    joints: Sequence[str],
) -> list[str]:
    """Return the names of coefficients of rare effects that are not 0, by those of each effect."""
    names: list[str] = []
    for name, effect in EFFECTS.items():
        if effect.rare:
            of_effect = effect.coefficient_names(joints)
            names += compress(of_effect, coefficients.get(name, ()))
    return names


def extend(
    robot: Robot,
    parameters: Sequence[Parameter],
    extensions: Sequence[str] = (),
    rotation_numbers: RotationNumbers = "vector",
) -> ExtendedModel:
    """Return the model of a robot with free parameters and some of :data:`.EFFECTS`."""
    indices = [p.index for p in parameters]
    ball = BallModel(robot, indices, rotation_numbers)
    rigid = ExtendedModel(
        robot=robot,
        parameters=tuple(parameters),
        ball=ball,
        extensions=(),
    )
    return rigid.with_effects(extensions)
