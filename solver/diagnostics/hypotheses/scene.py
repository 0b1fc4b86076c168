"""Recordings as a linear model: residuals of samples about a fit, then those of known distances.

Nuisance parameters are the centres, the geometry, the effects beyond it, and the caliper.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, pairwise

import numpy as np

from ...bayes.model import ExtendedModel, deflected, design_matrix, extend
from ...bayes.model.effects import BACKLASH, CURVE, EFFECTS, GAIN, Effect, Readings
from ...data import STANDARD_LOAD, Known, Load, Measurement
from ...robot import Parameter, Robot, even_bodies
from . import nuisances
from .seats import Seat, measured_points, seats_of

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
    """Derivative of the logarithm of the arm's size by the geometry, shape (n,)."""
    centres: np.ndarray
    """Places of the seats, sockets and then frames of instruments, shape (S, 3) [m]."""
    noise: float
    """Expected of a sound recording, per axis [m]."""
    noise_width: float
    """Of its logarithm, above that."""
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
    sample_numbers: np.ndarray | None = None
    """Number of each sample in its socket, where some were left out, shape (N,)."""
    play: float = BACKLASH.typical_shift
    """Half of the play that joints of servo arms have [rad]."""
    wide: float = 1.0
    """Factor on the usual sizes of elasticity and transmission error."""
    explained: tuple[tuple[slice, np.ndarray, np.ndarray], ...] = ()
    """Rows, columns and shift of each explanation that was accepted already."""

    @cached_property
    def q(self) -> np.ndarray:
        """Joint positions, shape (N, m)."""
        if self.readings is not None:
            return self.readings
        return np.concatenate([m.positions for m in self.measurements])

    @cached_property
    def labels(self) -> tuple[Seat, ...]:
        """Placement and number of each socket; then the frames of instruments."""
        return seats_of(self.measurements)[0]

    @cached_property
    def sockets(self) -> np.ndarray:
        """Index of each sample's seat, shape (N,)."""
        return seats_of(self.measurements)[1]

    @cached_property
    def points(self) -> np.ndarray:
        """Balls in their frame as instruments measured them, zero in sockets, shape (N, 3) [m]."""
        return measured_points(self.measurements)

    @cached_property
    def offsets(self) -> np.ndarray:
        """The same turned into the base's axes, R y, shape (N, 3) [m]."""
        return np.einsum("nij,nj->ni", self.R[self.sockets], self.points)

    @cached_property
    def seats(self) -> np.ndarray:
        """Where each sample has the place of its seat, Phi(q) - R y, shape (N, 3) [m]."""
        return self.linear[0] - self.offsets

    @cached_property
    def frames(self) -> list[int]:
        """Indices of the seats that are frames of instruments."""
        return [k for k, (_, socket) in enumerate(self.labels) if socket < 0]

    @cached_property
    def numbers(self) -> np.ndarray:
        """Number of each sample in its socket, from 0, shape (N,)."""
        if self.sample_numbers is not None:
            return self.sample_numbers
        counts = chain.from_iterable(m.counts for m in self.measurements)
        return np.concatenate([*map(np.arange, counts)])

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Samples of each placement."""
        ends = np.cumsum([0, *(sum(m.counts) for m in self.measurements)]).tolist()
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
    def torques(self) -> np.ndarray:
        """Moments that hold the joints, by their zeros as fitted, shape (N, 3 m) [N m]."""
        # they decide on which side of its play a joint rests
        off = self.x[len(self.parameters) :] if self.zeros else 0.0
        moments = [
            self.load.of(m.placement).moments(self.heavy, m.positions + off, m.efforts)
            for m in self.measurements
        ]
        return np.concatenate(moments)

    @cached_property
    def clocks(self) -> np.ndarray:
        """Index, time [s] and temperature [K] from each placement's first sample on, (N, 3)."""
        return np.concatenate([m.clocks for m in self.measurements])

    @property
    def as_readings(self) -> Readings:
        """All samples as effects see them."""
        return Readings(self.q, self.torques, self.clocks)

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
        of_samples = (self.seats - self.centres[self.sockets]).ravel()
        slopes = self.linear[1][:, :, : len(self.x)].reshape(-1, len(self.x))
        of_samples = of_samples - slopes @ self.x  # beside those at the nominal model
        of_distances = [n - k.distance for n, k in zip(self.expected, self.known, strict=True)]
        r = np.concatenate([of_samples, nuisances.DISTANCE_WEIGHT * np.array(of_distances)])
        for rows, _, shift in self.explained:
            r[rows] -= shift
        return r

    @cached_property
    def expected(self) -> list[float]:
        """Known distances as the fit has them [m]."""
        pairs = [self.centres[k.second] - self.centres[k.first] for k in self.known]
        return [max(float(np.linalg.norm(d)), 1e-12) for d in pairs]

    @cached_property
    def nuisances(self) -> np.ndarray:
        """Derivatives by the nuisance parameters in units of their priors, shape (3 N + K, n)."""
        every, last = self.all_samples, slice(3 * len(self.q), 3 * len(self.q) + len(self.known))
        coarse = self.zeros or self.noise > COARSE
        centres = nuisances.of_centres(self.centres, self.sockets, self.known, self.expected)
        places = [*zip(self.measurements, self.places, strict=True)]
        play = nuisances.of_play(self.by_joints, self.sockets, len(self.centres), self.noise)
        parts = [
            (slice(0, last.stop), centres),
            (every, self.by_geometry @ self.usual),
            (every, self.of_effects()),
            (last, nuisances.of_calipers(self.known)),
            (every, nuisances.of_turns(self.offsets, self.sockets, self.frames)),
            *nuisances.of_differences(self.robot, self.q, places),
            *([(every, play)] if coarse else []),
            *((rows, columns) for rows, columns, _ in self.explained),
        ]
        found = [np.zeros((last.stop, columns.shape[1])) for _, columns in parts]
        for full, (rows, columns) in zip(found, parts, strict=True):
            full[rows] = columns
        return np.hstack(found)

    @cached_property
    def usual(self) -> np.ndarray:
        """Root of the covariance of the geometry, shape (n, n)."""
        return nuisances.root_of_geometry(self.parameters, self.by_scale)

    @cached_property
    def by_readings(self) -> np.ndarray:
        """Derivatives of the balls by true positions and tilts, whatever the load, (N, 3, 3 m)."""
        turned, turns = design_matrix(self.effects, self.as_readings)
        true = deflected(self.q, turned, turns, self.start[len(self.parameters) :])
        return self.model.ball.linearise(self.model.values(self.start), true).by_joints

    def of_effects(
        self, *, elastic: bool = False, by_readings: np.ndarray | None = None
    ) -> np.ndarray:
        """Return derivatives of samples' residuals by effects, or elastic ones, in their widths.

        Scenes of other loads share :attr:`by_readings`.
        """
        turned, turns = design_matrix(self.effects, self.as_readings)
        slopes = self.by_readings if by_readings is None else by_readings
        columns = -(slopes[:, :, turned] * turns[:, None]).reshape(3 * len(self.q), -1)
        every = self.widths_of_effects(elastic=elastic)
        return columns[:, every > 0] * every[every > 0]

    def widths_of_effects(self, *, elastic: bool = False) -> np.ndarray:
        """Return the widths of effects' coefficients by how much they turn the joints here."""
        widths = [np.zeros(0)]
        for effect in self.effects:
            turns: np.ndarray = effect.turns(self.as_readings)
            usual = max(float(np.linalg.norm(turns)) / turns.size**0.5, 1e-6)
            wide = (self.wide if effect.learned else 1.0) * (effect.shared_by_type or not elastic)
            widths += [np.full(turns.shape[1], wide * effect.typical_shift / usual)]
        return np.concatenate(widths)

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
        x = self._ridge(self.all_samples, sigma)[: self.centres.size]
        return replace(self, centres=self.centres + nuisances.CENTRE * x.reshape(-1, 3))

    def _ridge(self, rows: slice, sigma: float) -> np.ndarray:
        B, r = self.nuisances[rows], self.residuals[rows]
        return np.linalg.solve(B.T @ B + sigma**2 * np.eye(B.shape[1]), B.T @ r)

    @cached_property
    def remaining(self) -> np.ndarray:
        """Residuals of samples after a fit of the nuisance parameters, shape (N, 3) [m]."""
        left = self.residuals - self.nuisances @ self._ridge(slice(None), self.noise)
        return left[self.all_samples].reshape(-1, 3)

    def rows(self, samples: slice) -> slice:
        """Return the rows of some samples' residuals."""
        return slice(3 * samples.start, 3 * samples.stop)

    @property
    def all_samples(self) -> slice:
        """The rows of all samples' residuals."""
        return slice(0, 3 * len(self.q))

    def measured(self, placement: str) -> Measurement:
        """Return a placement by its name."""
        return next(m for m in self.measurements if m.name == placement)

    def named(self, place: int) -> dict[str, str]:
        """Return the name of a placement, as a parameter of explanations."""
        return {"placement": self.measurements[place].name}

    def sample(self, place: int, row: int) -> dict[str, int]:
        """Return socket, index in it, and the numbers as recorded, of a placement's sample.

        A point that an instrument measured has its number in the recording, too, from 1.
        """
        at = self.places[place].start + row
        recorded = self.measurements[place].placement.samples[int(self.times[place][row])]
        named = {"number": recorded.number, "place": recorded.place}
        if recorded.point is not None:
            named["point"] = int(self.times[place][row]) + 1
        return {"socket": recorded.socket, "sample": int(self.numbers[at]), **named}

    def first_from(self, place: int, rank: int) -> dict[str, object]:
        """Return placement, socket and number of the first sample from a time on."""
        row = int(np.argmax(self.times[place] == rank))
        return {**self.named(place), **self.sample(place, row)}
