"""The arm that recorded samples: balls, linear about a fit, and effects under the load."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...identification.data import STANDARD_LOAD, Load, Samples
from ...identification.effects import CURVE, EFFECTS, GAIN, Effect
from ...identification.model import ExtendedModel, Prediction, design_matrix, extend
from ...identification.robot import Parameter, Robot, crude_bodies
from .layout import Layout

SMALLEST_TURN = 1e-6
"""Least turn of the joints that is reckoned with where an effect hardly shows [rad]."""


@dataclass(frozen=True, kw_only=True)
class LoadedArm(Layout):
    """Samples of an arm under a load, about a fit of its geometry."""

    robot: Robot
    parameters: tuple[Parameter, ...]
    x: np.ndarray
    """Change of the geometry, and joint offsets if any, at which all is linear, shape (n,)."""
    load: Load = STANDARD_LOAD
    """Gravity and payload, as given."""
    zeros: bool = False
    """True where joints have offsets of degrees, and gears have play."""
    wide: float = 1.0
    """Factor on the usual sizes of elasticity and transmission error."""

    # Balls, by the model about which all is linear

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Effects beyond the geometry that a sound arm may have; curves need more samples."""
        effects: list[Effect] = []
        for effect in EFFECTS.values():
            beyond_geometry = effect not in (CURVE, GAIN)
            if beyond_geometry and (self.zeros or effect.learned):
                effects.append(effect)
        return tuple(effects)

    @cached_property
    def model(self) -> ExtendedModel:
        """Geometry and effects as one model."""
        names = [effect.name for effect in self.effects]
        return extend(self.robot, self.parameters, names)

    @cached_property
    def start(self) -> np.ndarray:
        """Unknowns of the model at which all is linear."""
        count = self.model.size - len(self.x)
        of_effects = np.zeros(count)
        return np.append(self.x, of_effects)

    @cached_property
    def linear(self) -> Prediction:
        """Balls, and their derivatives by geometry and effects, and by joints."""
        return self.model.linearise(self.start, self.loaded_samples)

    @cached_property
    def by_geometry(self) -> np.ndarray:
        """Derivatives of the residuals of samples by the geometry, shape (3 N, n)."""
        n = len(self.parameters)
        slopes = -self.linear.by_unknowns[:, :, :n]
        return slopes.reshape(-1, n)

    @cached_property
    def by_joints(self) -> np.ndarray:
        """Derivatives of the balls by the joints' readings, shape (N, 3, m)."""
        if not self.zeros:
            return self.linear.by_joints
        # with play, those are as noisy as each joint is
        n, m = len(self.parameters), self.q.shape[1]
        return self.linear.by_unknowns[:, :, n : n + m]

    # Effects beyond the geometry

    @cached_property
    def heavy(self) -> Robot:
        """The robot; without masses with crude ones, since it bends as well."""
        bodies = self.robot.bodies or crude_bodies(self.robot.joints)
        return replace(self.robot, bodies=bodies)

    @cached_property
    def loaded_samples(self) -> Samples:
        """All samples as effects see them; moments are those that hold the joints as fitted."""
        return self.samples_under(self.load)

    def samples_under(self, load: Load) -> Samples:
        """Return all samples as effects would see them under a load."""
        measurements = self.measurements
        if self.zeros:  # they decide on which side of its play a joint rests
            zeros = self.x[len(self.parameters) :]
            measurements = [m.shifted(zeros) for m in measurements]
        return replace(load.samples(self.heavy, *measurements), q=self.q)

    @cached_property
    def by_readings(self) -> np.ndarray:
        """Derivatives of the balls by true positions and tilts, whatever the load, (N, 3, 3 m)."""
        design = design_matrix(self.effects, self.loaded_samples)
        coefficients = self.start[len(self.parameters) :]
        true = design.true_positions(self.q, coefficients)
        values = self.model.values(self.start)
        return self.model.ball.linearise(values, true).by_joints

    def of_effects(self, samples: Samples) -> np.ndarray:
        """Return derivatives of samples' residuals by effects, in their widths, (3 N, p)."""
        axes, turns = design_matrix(self.effects, samples)
        by_axes = self.by_readings[:, :, axes]
        slopes = -by_axes * turns[:, None]
        columns = slopes.reshape(3 * len(self.q), -1)
        return columns * self.widths_of_effects(samples)

    def widths_of_effects(self, samples: Samples) -> np.ndarray:
        """Return the widths of effects' coefficients by how much they turn the joints, (p,)."""
        widths = [np.zeros(0)]
        for effect in self.effects:
            turns: np.ndarray = effect.turns(samples)
            usual = float(np.mean(turns**2)) ** 0.5
            shift = effect.typical_shift
            if effect.learned:
                shift *= self.wide
            width = shift / max(usual, SMALLEST_TURN)
            coefficients = turns.shape[1]
            widths.append(np.full(coefficients, width))
        return np.concatenate(widths)

    @property
    def is_elastic(self) -> np.ndarray:
        """True for coefficients of elasticity among those of effects, shape (p,)."""
        elastic = [effect.elastic for effect in self.effects]
        counts = [rows.stop - rows.start for rows in self.model.slices]
        return np.repeat(elastic, counts)
