"""Recordings as a linear model: residuals of samples about a fit, then those of known distances.

Nuisance parameters are the centres, the geometry, the effects beyond it, and the caliper.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ...bayes.model import (
    ExtendedModel,
    design_matrix,
    extend,
    shifts_by,
    width_of,
)
from ...bayes.model.effects import BACKLASH, CURVE, EFFECTS, GAIN, Effect, Readings
from ...data import STANDARD_LOAD, Known, Load, Measurement
from ...robot import Parameter, Robot, even_bodies
from . import nuisances
from .samples import Samples, Seat, samples_of, seats_of

COARSE = 4e-4
"""Arms that repeat worse than this have gears with play [m]."""


@dataclass(frozen=True)
class Scene:
    """Samples of all placements, seat after seat, the known distances, and prior knowledge."""

    robot: Robot
    parameters: tuple[Parameter, ...]
    measurements: tuple[Measurement, ...]
    known: tuple[Known[int], ...]
    """Known distances, by indices of sockets."""
    x: np.ndarray
    """Change of the geometry, and joint offsets if any, at which all is linear, shape (n,)."""
    by_scale: np.ndarray
    """Derivative of the logarithm of the arm's size by the unknowns, geometry first."""
    centres: np.ndarray
    """Places of the seats, sockets and then frames of instruments, shape (S, 3) [m]."""
    noise: float
    """Expected of a sound recording, per axis [m]."""
    noise_width: float
    """Of its logarithm, above that."""
    numbers: np.ndarray
    """Number of each sample in its socket, from 0; some may have been left out, shape (N,)."""
    R: np.ndarray
    """Rotations of the seats, shape (S, 3, 3); of sockets they are 1."""
    floors: tuple[float, ...] = ()
    """Error of a fit to each placement alone [m]."""
    load: Load = STANDARD_LOAD
    """Gravity and payload, as given."""
    zeros: bool = False
    """True where joints have offsets of degrees, and gears have play."""
    readings: np.ndarray | None = None
    """Corrected joint positions, shape (N, m); None for those recorded."""
    play: float = BACKLASH.typical_shift
    """Half of the play that joints of servo arms have [rad]."""
    wide: float = 1.0
    """Factor on the usual sizes of elasticity and transmission error."""
    explained: tuple[tuple[slice, np.ndarray, np.ndarray], ...] = ()
    """Rows, columns and shift of each explanation that was accepted already."""

    @cached_property
    def samples(self) -> Samples:
        """Joint positions, the seats of the balls, and what instruments measured."""
        recorded = samples_of(self.measurements)
        return (
            recorded
            if self.readings is None
            else replace(recorded, positions=self.readings)
        )

    @property
    def q(self) -> np.ndarray:
        """Joint positions, shape (N, m)."""
        return self.samples.positions

    @property
    def sockets(self) -> np.ndarray:
        """Index of each sample's seat, shape (N,)."""
        return self.samples.sockets

    @property
    def frames(self) -> list[int]:
        """Indices of the seats that are frames of instruments."""
        return self.samples.frames

    @cached_property
    def labels(self) -> tuple[Seat, ...]:
        """Placement and number of each socket; then the frames of instruments."""
        return seats_of(self.measurements)[0]

    @cached_property
    def offsets(self) -> np.ndarray:
        """Balls from the origins of their frames, R y, zero in sockets, shape (N, 3) [m]."""
        return self.samples.offsets(self.R)

    @cached_property
    def seats(self) -> np.ndarray:
        """Where each sample has the place of its seat, Phi(q) - R y, shape (N, 3) [m]."""
        return self.linear[0] - self.offsets

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Samples of each placement."""
        counts = [len(m.positions) for m in self.measurements]
        ends = np.cumsum([0, *counts]).tolist()
        return tuple(slice(a, b) for a, b in pairwise(ends))

    @property
    def times(self) -> tuple[np.ndarray, ...]:
        """Rank of each sample of each placement in the order of recording."""
        return tuple(m.order for m in self.measurements)

    @cached_property
    def linear(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ball centres, shape (N, 3), and derivatives by geometry and effects, and by joints."""
        return self.model.linearise(self.start, self.q, self.torques, self.clocks)

    @cached_property
    def model(self) -> ExtendedModel:
        """Geometry and effects as one model."""
        return extend(self.robot, self.parameters, [e.name for e in self.effects])

    @cached_property
    def start(self) -> np.ndarray:
        """Unknowns of the model at which all is linear."""
        return np.append(self.x, np.zeros(self.model.size - len(self.x)))

    @cached_property
    def clocks(self) -> np.ndarray:
        """Index, time [s] and temperature [K] from each placement's first sample on, (N, 3)."""
        return np.concatenate([m.clocks for m in self.measurements])

    @property
    def torques(self) -> np.ndarray:
        """Moments that hold the joints, by their zeros as fitted, shape (N, 3 m) [N m]."""
        return self.as_readings.moments

    @cached_property
    def as_readings(self) -> Readings:
        """All samples as effects see them."""
        return self.readings_under(self.load)

    def readings_under(self, load: Load) -> Readings:
        """Return all samples as effects would see them under a load."""
        # zeros decide on which side of its play a joint rests
        zeros = self.x[len(self.parameters) :] if self.zeros else 0.0
        moments = [
            load.of(m.placement).moments(self.heavy, m.positions + zeros, m.efforts)
            for m in self.measurements
        ]
        return Readings(self.q, np.concatenate(moments), self.clocks)

    @cached_property
    def heavy(self) -> Robot:
        """The robot; without masses in its model with one at each joint, since it bends as well."""
        bodies = self.robot.bodies or even_bodies(self.robot.joints)
        return replace(self.robot, bodies=bodies)

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Effects beyond the geometry that a sound arm may have; curves need more samples."""
        beyond = [e for e in EFFECTS.values() if e not in (CURVE, GAIN)]
        return tuple(e for e in beyond if self.zeros or e.learned)

    @cached_property
    def by_geometry(self) -> np.ndarray:
        """Derivatives of the residuals of samples by the geometry, shape (3 N, n)."""
        n = len(self.parameters)
        return -self.linear[1][:, :, :n].reshape(-1, n)

    @cached_property
    def by_joints(self) -> np.ndarray:
        """Derivatives of the balls by the joints' readings, shape (N, 3, m)."""
        _, by_unknowns, by_joints = self.linear
        n, m = len(self.parameters), by_joints.shape[2]
        # with play, by_joints are as noisy as each joint is
        return by_unknowns[:, :, n : n + m] if self.zeros else by_joints

    @cached_property
    def residuals(self) -> np.ndarray:
        """Residuals of samples, then of distances, shape (3 N + K,) [m]."""
        # beside those at the nominal model
        by_x = self.linear[1][:, :, : len(self.x)]
        of_samples = self.seats - self.centres[self.sockets] - by_x @ self.x
        of_lengths = self.expected - [length.distance for length in self.known]
        r = np.append(of_samples, nuisances.DISTANCE_WEIGHT * of_lengths)
        for rows, _, shift in self.explained:
            r[rows] -= shift
        return r

    @cached_property
    def spans(self) -> np.ndarray:
        """Vectors between sockets of known distances, as the fit has them, shape (K, 3) [m]."""
        spans = [self.centres[k.second] - self.centres[k.first] for k in self.known]
        return np.reshape(spans, (len(self.known), 3))

    @cached_property
    def expected(self) -> np.ndarray:
        """Known distances as the fit has them, shape (K,) [m]."""
        return np.linalg.norm(self.spans, axis=1).clip(min=1e-12)

    @cached_property
    def nuisances(self) -> np.ndarray:
        """Derivatives by the nuisance parameters in units of their priors, shape (3 N + K, n)."""
        samples, lengths = self.all_samples, self.all_lengths
        of_frames = nuisances.TURN * self.samples.by_turns(self.offsets)
        every, units = slice(0, lengths.stop), self.spans / self.expected[:, None]
        parts = [
            (every, nuisances.of_centres(self.sockets, self.known, units)),
            (samples, self.by_geometry @ self.usual),
            (samples, self.of_effects(self.as_readings)),
            (lengths, nuisances.of_calipers(self.known)),
            (samples, of_frames.reshape(samples.stop, -1)),
        ]
        for m, place in zip(self.measurements, self.places, strict=True):
            for difference in m.apart:
                shifts = shifts_by(self.robot, self.q[place], m.order, difference)
                columns = width_of(difference) * shifts.reshape(-1, shifts.shape[2])
                parts.append((self.rows(place), columns))
        if self.zeros or self.noise > COARSE:
            play = nuisances.of_play(self.by_joints, self.sockets, self.noise)
            parts.append((samples, play))
        parts += [(rows, columns) for rows, columns, _ in self.explained]
        return np.hstack([self.in_rows(rows, columns) for rows, columns in parts])

    def in_rows(self, rows: slice, columns: np.ndarray) -> np.ndarray:
        """Return columns, or a shift, of some rows as those of all residuals, (3 N + K, ...)."""
        full = np.zeros((self.all_lengths.stop, *columns.shape[1:]))
        full[rows] = columns
        return full

    @cached_property
    def usual(self) -> np.ndarray:
        """Root of the covariance of the geometry, shape (n, n)."""
        widths = nuisances.widths_of(self.parameters)
        by_scale = self.by_scale[: len(widths)]
        precision = nuisances.precision(widths, by_scale, nuisances.ARMS)
        return np.linalg.cholesky(np.linalg.inv(precision))

    @cached_property
    def by_readings(self) -> np.ndarray:
        """Derivatives of the balls by true positions and tilts, whatever the load, (N, 3, 3 m)."""
        design = design_matrix(self.effects, self.as_readings)
        coefficients = self.start[len(self.parameters) :]
        true = design.true_positions(self.q, coefficients)
        values = self.model.values(self.start)
        return self.model.ball.linearise(values, true).by_joints

    def of_effects(self, readings: Readings) -> np.ndarray:
        """Return derivatives of samples' residuals by effects, in their widths, (3 N, p)."""
        axes, turns = design_matrix(self.effects, readings)
        slopes = -self.by_readings[:, :, axes] * turns[:, None]
        columns = slopes.reshape(3 * len(self.q), -1)
        return columns * self.widths_of_effects(readings)

    def widths_of_effects(self, readings: Readings) -> np.ndarray:
        """Return the widths of effects' coefficients by how much they turn the joints, (p,)."""
        widths = [np.zeros(0)]
        for effect in self.effects:
            turns: np.ndarray = effect.turns(readings)
            usual = max(float(np.mean(turns**2)) ** 0.5, 1e-6)
            wide = self.wide if effect.learned else 1.0
            widths.append(np.full(turns.shape[1], wide * effect.typical_shift / usual))
        return np.concatenate(widths)

    @property
    def is_elastic(self) -> np.ndarray:
        """True for coefficients of elasticity among those of effects, shape (p,)."""
        elastic = [effect.shared_by_type for effect in self.effects]
        return np.repeat(elastic, [s.stop - s.start for s in self.model.slices])

    @cached_property
    def whitening(self) -> np.ndarray | None:
        """Inverse root of each sample's covariance beside the noise's square, shape (N, 3, 3)."""
        if not self.zeros:
            return None
        # a joint with play that gravity does not load rests on either side
        turned = self.linear[2] * (self.play / self.noise)
        variances, axes = np.linalg.eigh(np.eye(3) + turned @ turned.transpose(0, 2, 1))
        return axes * variances[:, None] ** -0.5 @ axes.transpose(0, 2, 1)

    def recentred(self, sigma: float) -> "Scene":
        """Return the scene about the sockets' most probable centres by the samples alone."""
        rows = self.all_samples
        x = _ridge(self.nuisances[rows], self.residuals[rows], sigma)
        of_centres = x[: self.centres.size].reshape(-1, 3)
        shifts = nuisances.CENTRE * of_centres
        return replace(self, centres=self.centres + shifts)

    def left_of(self, residuals: np.ndarray) -> np.ndarray:
        """Return what a fit of the nuisance parameters leaves of residuals, shape (3 N + K,)."""
        return residuals - self.nuisances @ _ridge(
            self.nuisances, residuals, self.noise
        )

    @cached_property
    def remaining(self) -> np.ndarray:
        """Residuals of samples after a fit of the nuisance parameters, shape (N, 3) [m]."""
        return self.left_of(self.residuals)[self.all_samples].reshape(-1, 3)

    def rows(self, samples: slice) -> slice:
        """Return the rows of some samples' residuals."""
        return slice(3 * samples.start, 3 * samples.stop)

    @property
    def every(self) -> slice:
        """All samples."""
        return slice(0, len(self.q))

    @property
    def all_samples(self) -> slice:
        """The rows of all samples' residuals."""
        return slice(0, 3 * len(self.q))

    @property
    def all_lengths(self) -> slice:
        """The rows of the residuals of known distances."""
        first = 3 * len(self.q)
        return slice(first, first + len(self.known))

    def measured(self, placement: str) -> Measurement:
        """Return a placement by its name."""
        return next(m for m in self.measurements if m.name == placement)

    def named(self, place: int) -> dict[str, str]:
        """Return the name of a placement, as a parameter of explanations."""
        return {"placement": self.measurements[place].name}

    def sample(self, place: int, row: int) -> dict[str, Any]:
        """Return placement, socket, index in it, and the numbers as recorded, of a sample.

        A point that an instrument measured has its number in the recording, too, from 1.
        """
        rank = int(self.times[place][row])
        number = int(self.numbers[self.places[place].start + row])
        recorded = self.measurements[place].placement.samples[rank]
        named = {"number": recorded.number, "place": recorded.place}
        if recorded.point is not None:
            named["point"] = rank + 1
        return {
            **self.named(place),
            "socket": recorded.socket,
            "sample": number,
            **named,
        }


def _ridge(B: np.ndarray, r: np.ndarray, sigma: float) -> np.ndarray:
    """Return x = (B^T B + sigma^2)^-1 B^T r, the most probable unknowns of r = B x + noise."""
    return np.linalg.solve(B.T @ B + sigma**2 * np.eye(B.shape[1]), B.T @ r)
