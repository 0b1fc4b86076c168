"""Recordings as a linear model: residuals of samples about a fit, then those of known distances.

Nuisance parameters are the centres, the geometry, the effects beyond it, and the caliper.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...bayes.model import ExtendedModel, extend
from ...bayes.model.effects import BACKLASH, CURVE, EFFECTS, Effect
from ...data import SEAT_DEVIATION, STANDARD_LOAD, Known, Load, Measurement
from ...robot import Parameter, Robot, even_bodies

TRANSLATION, ROTATION, BALL = 2e-3, 1e-2, 0.1
"""Widths of the priors [m], [rad]: as far as arms are from their models."""
ARMS = 0.002
"""Standard deviation of the scale of real arms about their models."""
CENTRE = 0.3
"""Width of the prior of a socket's centre about the fit's [m]."""
COARSE = 4e-4
"""Arms that repeat worse than this have gears with play [m]."""
SIDES = 0.4
"""Share of the play by which the rest of a joint differs from socket to socket."""
DISTANCE_WEIGHT = 3.0
"""Weight of a distance relative to a sample: centres err by a third of a sample's noise, since the
errors of samples are correlated."""


def widths_of(parameters: Sequence[Parameter]) -> np.ndarray:
    """Return the widths of the priors of a geometry's parameters, shape (n,) [m, rad]."""
    return np.array(
        [BALL if p.of_ball else TRANSLATION if p.unit == "m" else ROTATION for p in parameters]
    )


@dataclass(frozen=True)
class Scene:
    """Samples of all placements, socket after socket, the known distances, and prior knowledge."""

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
    """Of the sockets, shape (S, 3) [m]."""
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
    def labels(self) -> tuple[tuple[str, int], ...]:
        """Placement and number of each socket."""
        return tuple((m.name, k) for m in self.measurements for k in m.sockets)

    @cached_property
    def sockets(self) -> np.ndarray:
        """Index of each sample's socket, shape (N,)."""
        counts = [n for m in self.measurements for n in m.counts]
        return np.repeat(np.arange(len(counts)), counts)

    @cached_property
    def numbers(self) -> np.ndarray:
        """Number of each sample in its socket, from 0, shape (N,)."""
        every = (np.arange(n) for m in self.measurements for n in m.counts)
        return np.concatenate([*every]) if self.sample_numbers is None else self.sample_numbers

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Samples of each placement."""
        ends = np.cumsum([0, *(sum(m.counts) for m in self.measurements)]).tolist()
        return tuple(slice(a, b) for a, b in itertools.pairwise(ends))

    @property
    def times(self) -> tuple[np.ndarray, ...]:
        """Rank of each sample of each placement in the order of recording."""
        return tuple(m.order for m in self.measurements)

    @cached_property
    def linear(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ball centres, shape (N, 3), and derivatives by geometry and effects, and by joints."""
        return self.model.linearise(self.start, self.q, self.torques)

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
    def heavy(self) -> Robot:
        """The robot; without masses in its model with one at each joint, since it bends as well."""
        bodies = self.robot.bodies or even_bodies(self.robot.joints)
        return replace(self.robot, bodies=bodies)

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Effects beyond the geometry that a sound arm may have; curves need more samples."""
        return tuple(e for e in EFFECTS.values() if (self.zeros or e.learned) and e is not CURVE)

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
        of_samples = (self.linear[0] - self.centres[self.sockets]).ravel()
        slopes = self.linear[1][:, :, : len(self.x)].reshape(-1, len(self.x))
        of_samples = of_samples - slopes @ self.x  # beside those at the nominal model
        of_distances = [n - k.distance for n, k in zip(self.expected, self.known, strict=True)]
        r = np.concatenate([of_samples, DISTANCE_WEIGHT * np.array(of_distances)])
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
        parts = [
            (slice(0, last.stop), self._of_centres()),
            (every, self.by_geometry @ self.usual),
            (every, self.of_effects()),
            (last, self._of_calipers()),
            *([(every, self._of_play())] if coarse else []),
            *((rows, columns) for rows, columns, _ in self.explained),
        ]
        found = [np.zeros((last.stop, columns.shape[1])) for _, columns in parts]
        for full, (rows, columns) in zip(found, parts, strict=True):
            full[rows] = columns
        return np.hstack(found)

    def _of_centres(self) -> np.ndarray:
        S, K = len(self.centres), len(self.known)
        of_samples = np.kron(np.eye(S)[self.sockets], CENTRE * np.eye(3))
        of_known = np.zeros((K, S, 3))
        for row, k, length in zip(of_known, self.known, self.expected, strict=True):
            unit = (self.centres[k.second] - self.centres[k.first]) / length
            row[k.first] = DISTANCE_WEIGHT * CENTRE * unit
            row[k.second] = -row[k.first]
        return np.vstack([of_samples, of_known.reshape(K, 3 * S)])

    @cached_property
    def usual(self) -> np.ndarray:
        """Root of the covariance of the geometry, whose size is held to that of arms, (n, n)."""
        size = np.outer(self.by_scale, self.by_scale) / ARMS**2
        precision = np.diag(1 / widths_of(self.parameters) ** 2) + size
        return np.linalg.cholesky(np.linalg.inv(precision))

    def of_effects(self, *, elastic: bool = False) -> np.ndarray:
        """Return derivatives of samples' residuals by effects, or elastic ones, in their widths."""
        columns = -self.linear[1][:, :, len(self.parameters) :].reshape(3 * len(self.q), -1)
        every = self.widths_of_effects(elastic=elastic)
        return columns[:, every > 0] * every[every > 0]

    def widths_of_effects(self, *, elastic: bool = False) -> np.ndarray:
        """Return the widths of effects' coefficients by how much they turn the joints here."""
        widths = [np.zeros(0)]
        for effect in self.effects:
            turns: np.ndarray = effect.derivatives(self.q, self.torques)
            usual = max(float(np.linalg.norm(turns)) / turns.size**0.5, 1e-6)
            wide = (self.wide if effect.learned else 1.0) * (effect.shared_by_type or not elastic)
            widths += [np.full(turns.shape[1], wide * effect.typical_shift / usual)]
        return np.concatenate(widths)

    def _of_play(self) -> np.ndarray:
        """Offsets of the joints in each socket: gears with play rest on one side there."""
        lever = np.sqrt(np.mean(np.sum(self.by_joints**2, axis=1), axis=0)).clip(min=0.05)
        turned = self.by_joints * (SIDES * self.noise / lever)
        S, m = len(self.centres), turned.shape[2]
        found = np.zeros((len(turned), 3, S, m))
        found[np.arange(len(turned)), :, self.sockets] = turned
        return found.reshape(3 * len(turned), S * m)

    @cached_property
    def whitening(self) -> np.ndarray | None:
        """Inverse root of each sample's covariance beside the noise's square, shape (N, 3, 3)."""
        if not self.zeros:
            return None
        # a joint with play that gravity does not load rests on either side
        turned = self.linear[2] * (self.play / self.noise)
        variances, axes = np.linalg.eigh(np.eye(3) + turned @ turned.transpose(0, 2, 1))
        return axes * variances[:, None] ** -0.5 @ axes.transpose(0, 2, 1)

    def _of_calipers(self) -> np.ndarray:
        bases = sorted({k.distance for k in self.known if k.on_base})
        found = np.zeros((len(self.known), len(bases) + len(self.known)))
        for i, k in enumerate(self.known):
            own = SEAT_DEVIATION if k.on_base else k.deviation
            found[i, len(bases) + i] = DISTANCE_WEIGHT * own
            if k.on_base:
                found[i, bases.index(k.distance)] = DISTANCE_WEIGHT * k.deviation
        return found

    def recentred(self, sigma: float) -> "Scene":
        """Return the scene about the sockets' most probable centres by the samples alone."""
        x = self._ridge(self.all_samples, sigma)[: self.centres.size]
        return replace(self, centres=self.centres + CENTRE * x.reshape(-1, 3))

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
        """Return socket, index in it, and the numbers as recorded, of a placement's sample."""
        at = self.places[place].start + row
        recorded = self.measurements[place].placement.samples[int(self.times[place][row])]
        socket = self.labels[int(self.sockets[at])][1]
        named = {"number": recorded.number, "place": recorded.place}
        return {"socket": socket, "sample": int(self.numbers[at]), **named}

    def first_from(self, place: int, rank: int) -> dict[str, object]:
        """Return placement, socket and number of the first sample from a time on."""
        row = int(np.argmax(self.times[place] == rank))
        return {**self.named(place), **self.sample(place, row)}
