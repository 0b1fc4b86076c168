"""Recordings as a linear model: residuals of samples about a fit, then those of known distances.

Nuisance parameters are the centres, the geometry, the effects beyond it, and the caliper.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...bayes.model import (
    ExtendedModel,
    design_matrix,
    extend,
    shifts_by,
    width_of,
)
from ...bayes.model.effects import BACKLASH, CURVE, EFFECTS, GAIN, Effect
from ...data import STANDARD_LOAD, Load, Samples, joined
from ...robot import Parameter, Robot, even_bodies
from . import nuisances
from .layout import Layout
from .nuisances import DISTANCE_WEIGHT

COARSE = 4e-4
"""Arms that repeat worse than this have gears with play [m]."""
SMALLEST_TURN = 1e-6
"""Least turn of the joints that is reckoned with where an effect hardly shows [rad]."""


@dataclass(frozen=True, kw_only=True)
class Scene(Layout):
    """Samples and known distances of an arm about a fit, and prior knowledge."""

    robot: Robot
    parameters: tuple[Parameter, ...]
    x: np.ndarray
    """Change of the geometry, and joint offsets if any, at which all is linear, shape (n,)."""
    by_scale: np.ndarray
    """Derivative of the logarithm of the arm's size by the unknowns, geometry first."""
    centres: np.ndarray
    """Places of the seats, sockets and then frames of instruments, shape (S, 3) [m]."""
    R: np.ndarray
    """Rotations of the seats, shape (S, 3, 3); of sockets they are 1."""
    noise: float
    """Expected of a sound recording, per axis [m]."""
    noise_width: float
    """Of its logarithm, above that."""
    floors: tuple[float, ...] = ()
    """Error of a fit to each placement alone [m]."""
    load: Load = STANDARD_LOAD
    """Gravity and payload, as given."""
    zeros: bool = False
    """True where joints have offsets of degrees, and gears have play."""
    play: float = BACKLASH.typical_shift
    """Half of the play that joints of servo arms have [rad]."""
    wide: float = 1.0
    """Factor on the usual sizes of elasticity and transmission error."""
    explained: tuple[tuple[slice, np.ndarray, np.ndarray], ...] = ()
    """Rows, columns and shift of each explanation that was accepted already."""

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
    def linear(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ball centres, shape (N, 3), and derivatives by geometry and effects, and by joints."""
        return self.model.linearise(self.start, self.loaded_samples)

    @cached_property
    def offsets(self) -> np.ndarray:
        """Balls from the origins of their frames, R y, zero in sockets, shape (N, 3) [m]."""
        return self.samples.offsets(self.R)

    @cached_property
    def seats(self) -> np.ndarray:
        """Where each sample has the place of its seat, Phi(q) - R y, shape (N, 3) [m]."""
        balls, _, _ = self.linear
        return balls - self.offsets

    @cached_property
    def by_geometry(self) -> np.ndarray:
        """Derivatives of the residuals of samples by the geometry, shape (3 N, n)."""
        _, by_unknowns, _ = self.linear
        n = len(self.parameters)
        slopes = -by_unknowns[:, :, :n]
        return slopes.reshape(-1, n)

    @cached_property
    def by_joints(self) -> np.ndarray:
        """Derivatives of the balls by the joints' readings, shape (N, 3, m)."""
        _, by_unknowns, by_joints = self.linear
        if not self.zeros:
            return by_joints
        # with play, by_joints are as noisy as each joint is
        n, m = len(self.parameters), by_joints.shape[2]
        return by_unknowns[:, :, n : n + m]

    # Effects beyond the geometry

    @cached_property
    def heavy(self) -> Robot:
        """The robot; without masses in its model with one at each joint, since it bends as well."""
        bodies = self.robot.bodies or even_bodies(self.robot.joints)
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
        samples = [load.samples(self.heavy, m) for m in measurements]
        return replace(joined(samples), q=self.q)

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
        elastic: list[bool] = []
        pairs = zip(self.effects, self.model.slices, strict=True)
        for effect, rows in pairs:
            count = rows.stop - rows.start
            elastic += [effect.shared_by_type] * count
        return np.array(elastic, dtype=bool)

    # Residuals and nuisance parameters

    @cached_property
    def residuals(self) -> np.ndarray:
        """Residuals of samples, then of distances, shape (3 N + K,) [m]."""
        _, by_unknowns, _ = self.linear
        # beside those at the nominal model
        by_fitted = by_unknowns[:, :, : len(self.x)]
        fitted = by_fitted @ self.x
        centres = self.centres[self.sockets]
        of_samples = self.seats - centres - fitted
        distances = [length.distance for length in self.known]
        of_lengths = self.expected - distances
        residuals = np.append(of_samples, DISTANCE_WEIGHT * of_lengths)
        for rows, _, shift in self.explained:
            residuals[rows] -= shift
        return residuals

    @cached_property
    def spans(self) -> np.ndarray:
        """Vectors between sockets of known distances, as the fit has them, shape (K, 3) [m]."""
        first = [length.first for length in self.known]
        second = [length.second for length in self.known]
        return self.centres[second] - self.centres[first]

    @cached_property
    def expected(self) -> np.ndarray:
        """Known distances as the fit has them, shape (K,) [m]."""
        lengths = np.linalg.norm(self.spans, axis=1)
        return lengths.clip(min=1e-12)

    @cached_property
    def nuisances(self) -> np.ndarray:
        """Derivatives by the nuisance parameters in units of their priors, shape (3 N + K, n)."""
        samples, lengths = self.all_samples, self.all_lengths
        every = slice(0, lengths.stop)
        directions = self.spans / self.expected[:, None]
        centres = nuisances.of_centres(self.sockets, self.known, directions)
        turns = nuisances.TURN * self.samples.by_turns(self.offsets)
        parts = [
            (every, centres),
            (samples, self.by_geometry @ self.usual),
            (samples, self.of_effects(self.loaded_samples)),
            (lengths, nuisances.of_calipers(self.known)),
            (samples, turns.reshape(samples.stop, -1)),
            *self._differences(),
        ]
        if self.zeros or self.noise > COARSE:
            play = nuisances.of_play(self.by_joints, self.sockets, self.noise)
            parts.append((samples, play))
        parts += [(rows, columns) for rows, columns, _ in self.explained]
        return self.stacked(parts)

    def _differences(self) -> list[tuple[slice, np.ndarray]]:
        """Return rows and derivatives of what is otherwise throughout some placement."""
        parts: list[tuple[slice, np.ndarray]] = []
        for m, place in zip(self.measurements, self.places, strict=True):
            for difference in m.apart:
                shifts = shifts_by(self.robot, self.q[place], m.order, difference)
                width = width_of(difference)
                columns = width * shifts.reshape(-1, shifts.shape[2])
                rows = self.rows(place)
                parts.append((rows, columns))
        return parts

    @cached_property
    def usual(self) -> np.ndarray:
        """Root of the covariance of the geometry, shape (n, n)."""
        widths = nuisances.widths_of(self.parameters)
        by_scale = self.by_scale[: len(widths)]
        precision = nuisances.precision(widths, by_scale, nuisances.ARMS)
        return np.linalg.cholesky(np.linalg.inv(precision))

    @cached_property
    def whitening(self) -> np.ndarray | None:
        """Inverse root of each sample's covariance beside the noise's square, shape (N, 3, 3).

        A joint with play that gravity does not load rests on either side. None without play.
        """
        if not self.zeros:
            return None
        _, _, by_joints = self.linear
        J = by_joints * (self.play / self.noise)
        of_play = J @ J.transpose(0, 2, 1)
        covariance = np.eye(3) + of_play
        variances, axes = np.linalg.eigh(covariance)
        scaled = axes * variances[:, None] ** -0.5
        return scaled @ axes.transpose(0, 2, 1)

    # What a fit of the nuisance parameters leaves

    def recentred(self, sigma: float) -> "Scene":
        """Return the scene about the sockets' most probable centres by the samples alone."""
        rows = self.all_samples
        B = self.nuisances[rows]
        x = _ridge(B, self.residuals[rows], sigma)
        of_centres = x[: self.centres.size]
        shifts = nuisances.CENTRE * of_centres.reshape(-1, 3)
        return replace(self, centres=self.centres + shifts)

    def left_of(self, residuals: np.ndarray) -> np.ndarray:
        """Return what a fit of the nuisance parameters leaves of residuals, shape (3 N + K,)."""
        x = _ridge(self.nuisances, residuals, self.noise)
        return residuals - self.nuisances @ x

    @cached_property
    def remaining(self) -> np.ndarray:
        """Residuals of samples after a fit of the nuisance parameters, shape (N, 3) [m]."""
        errors = self.left_of(self.residuals)
        return errors[self.all_samples].reshape(-1, 3)


def _ridge(B: np.ndarray, r: np.ndarray, sigma: float) -> np.ndarray:
    """Return x = (B^T B + sigma^2)^-1 B^T r, the most probable unknowns of r = B x + noise."""
    unknowns = B.shape[1]
    precision = B.T @ B + sigma**2 * np.eye(unknowns)
    return np.linalg.solve(precision, B.T @ r)
