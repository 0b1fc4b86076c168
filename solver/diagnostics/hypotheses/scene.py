"""Recordings as a linear model: residuals of samples about a fit, then those of known distances.

Nuisance parameters are the centres, the geometry, the effects beyond it, and the caliper.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...identification.data import SEAT_DEVIATION
from ...identification.effects import BACKLASH
from ...identification.robot import Parameter
from .loaded_arm import LoadedArm

TRANSLATION = 2e-3
"""Width of the prior of a length [m]: as far as arms are from their models."""
ROTATION = 1e-2
"""The same of an angle [rad]."""
BALL = 0.1
"""The same of the ball's place [m]."""
ARMS = 0.002
"""Standard deviation of the scale of real arms about their models."""
CENTRE = 0.3
"""Width of the prior of a socket's centre about the fit's [m]."""
TURN = 1.0
"""Width of the prior of a frame's turn about the fit's [rad]."""
SIDES = 0.4
"""Share of the play by which the rest of a joint differs from socket to socket."""
SHORTEST = 0.05
"""Least distance of the balls from a joint that is reckoned with [m]."""
DISTANCE_WEIGHT = 3.0
"""Weight of a distance relative to a sample: centres err by a third of a sample's noise, since the
errors of samples are correlated."""
COARSE = 4e-4
"""Arms that repeat worse than this have gears with play [m]."""


def widths_of(parameters: Sequence[Parameter]) -> np.ndarray:
    """Return the widths of the priors of a geometry's parameters, shape (n,) [m, rad]."""
    usual = {"m": TRANSLATION, "rad": ROTATION}
    widths = [BALL if p.of_ball else usual[p.unit] for p in parameters]
    return np.array(widths)


def precision(
    widths: np.ndarray,
    by_scale: np.ndarray,
    scale: float,
) -> np.ndarray:
    """Return the inverse covariance of unknowns whose size is held to a scale, shape (n, n)."""
    return np.diag(widths**-2) + np.outer(by_scale, by_scale) / scale**2


@dataclass(frozen=True, kw_only=True)
class Scene(LoadedArm):
    """Samples and known distances of an arm about a fit, and prior knowledge."""

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
    play: float = BACKLASH.typical_shift
    """Half of the play that joints of servo arms have [rad]."""
    explained: tuple[tuple[slice, np.ndarray, np.ndarray], ...] = ()
    """Rows, columns and shift of each explanation that was accepted already."""

    # Residuals and nuisance parameters

    @cached_property
    def offsets(self) -> np.ndarray:
        """Balls from the origins of their frames, R y, zero in sockets, shape (N, 3) [m]."""
        return self.samples.offsets(self.R)

    @cached_property
    def seats(self) -> np.ndarray:
        """Place of its seat by each sample, Phi(q) - R y, shape (N, 3) [m]."""
        return self.linear.points - self.offsets

    @cached_property
    def residuals(self) -> np.ndarray:
        """Residuals of samples, then of distances, shape (3 N + K,) [m]."""
        # beside those at the nominal model
        by_fitted = self.linear.by_unknowns[:, :, : len(self.x)]
        fitted = by_fitted @ self.x
        of_samples = self.seats - self.centres[self.sockets] - fitted
        of_lengths = self.expected - self.distances
        residuals = np.append(of_samples, DISTANCE_WEIGHT * of_lengths)
        for rows, _, shift in self.explained:
            residuals[rows] -= shift
        return residuals

    def spans_of(self, places: np.ndarray) -> np.ndarray:
        """Return differences of the seats' places by known distances, shape (K, ...)."""
        first = [length.first for length in self.known]
        return places[[length.second for length in self.known]] - places[first]

    @cached_property
    def spans(self) -> np.ndarray:
        """Vectors between sockets of known distances, as the fit has them, shape (K, 3) [m]."""
        return self.spans_of(self.centres)

    @cached_property
    def distances(self) -> np.ndarray:
        """Known distances as measured, shape (K,) [m]."""
        return np.array([length.distance for length in self.known])

    @cached_property
    def on_base(self) -> np.ndarray:
        """True for those between the sockets of one base, shape (K,)."""
        return np.array([length.on_base for length in self.known], dtype=bool)

    @cached_property
    def expected(self) -> np.ndarray:
        """Known distances as the fit has them, shape (K,) [m]."""
        return np.linalg.norm(self.spans, axis=1).clip(min=1e-12)

    @cached_property
    def nuisances(self) -> np.ndarray:
        """Derivatives by the nuisance parameters in units of their priors, shape (3 N + K, n)."""
        samples = self.all_samples
        lengths = self.all_lengths
        every = slice(0, lengths.stop)
        turns = TURN * self.samples.by_turns(self.offsets)
        parts = [
            (every, self._by_centres()),
            (samples, self.by_geometry @ self.usual),
            (samples, self.of_effects(self.loaded_samples)),
            (lengths, self._by_calipers()),
            (samples, turns.reshape(samples.stop, -1)),
        ]
        if self.zeros or self.noise > COARSE:
            parts.append((samples, self._by_play()))
        parts += [(rows, columns) for rows, columns, _ in self.explained]
        return np.hstack([self.in_rows(rows, columns) for rows, columns in parts])

    def _by_centres(self) -> np.ndarray:
        """Return those by the places of all seats, shape (3 N + K, 3 S)."""
        seats = np.eye(self.samples.count)
        of_samples = np.kron(seats[self.sockets], np.eye(3))
        directions = self.spans / self.expected[:, None]
        between = -self.spans_of(seats)
        along = between[:, :, None] * directions[:, None]
        of_known = along.reshape(-1, of_samples.shape[1])
        return CENTRE * np.vstack([of_samples, DISTANCE_WEIGHT * of_known])

    def _by_play(self) -> np.ndarray:
        """Return those of samples by offsets of m joints in each of S seats, shape (3 N, S m).

        Gears with play rest on one side there.
        """
        squares = np.sum(self.by_joints**2, axis=1)
        levers = np.sqrt(np.mean(squares, axis=0))
        offsets = SIDES * self.noise / levers.clip(min=SHORTEST)
        shifts = self.by_joints * offsets
        seats = np.eye(self.samples.count)
        in_seats = seats[self.sockets][:, None, :, None]
        columns = in_seats * shifts[:, :, None]
        return columns.reshape(3 * len(shifts), -1)

    def _by_calipers(self) -> np.ndarray:
        """Return those of K distances by the errors of their measurement, shape (K, bases + K)."""
        deviations = np.array([length.deviation for length in self.known])
        bases = np.unique(self.distances[self.on_base])
        is_of_base = self.distances[:, None] == bases
        of_bases = is_of_base * (self.on_base * deviations)[:, None]
        each = np.where(self.on_base, SEAT_DEVIATION, deviations)
        return DISTANCE_WEIGHT * np.hstack([of_bases, np.diag(each)])

    @cached_property
    def usual(self) -> np.ndarray:
        """Root of the covariance of the geometry, shape (n, n)."""
        widths = widths_of(self.parameters)
        by_scale = self.by_scale[: len(widths)]
        return np.linalg.cholesky(np.linalg.inv(precision(widths, by_scale, ARMS)))

    @cached_property
    def whitening(self) -> np.ndarray | None:
        """Inverse root of each sample's covariance beside the noise's square, shape (N, 3, 3).

        A joint with play that gravity does not load rests on either side. None without play.
        """
        if not self.zeros:
            return None
        J = self.linear.by_joints * (self.play / self.noise)
        of_play = J @ J.swapaxes(1, 2)
        variances, axes = np.linalg.eigh(np.eye(3) + of_play)
        scaled = axes * variances[:, None] ** -0.5
        return scaled @ axes.swapaxes(1, 2)

    # What a fit of the nuisance parameters leaves

    def recentred(self, sigma: float) -> "Scene":
        """Return the scene about the sockets' most probable centres by the samples alone."""
        rows = self.all_samples
        x = _ridge(self.nuisances[rows], self.residuals[rows], sigma)
        shifts = CENTRE * x[: self.centres.size].reshape(-1, 3)
        return replace(self, centres=self.centres + shifts)

    @cached_property
    def remaining(self) -> np.ndarray:
        """Residuals of samples after a fit of the nuisance parameters, shape (N, 3) [m]."""
        x = _ridge(self.nuisances, self.residuals, self.noise)
        errors = self.residuals - self.nuisances @ x
        return errors[self.all_samples].reshape(-1, 3)


def _ridge(
    B: np.ndarray,
    r: np.ndarray,
    sigma: float,
) -> np.ndarray:
    """Return x = (B^T B + sigma^2)^-1 B^T r, the most probable unknowns of r = B x + noise."""
    P = B.T @ B + sigma**2 * np.eye(B.shape[1])
    return np.linalg.solve(P, B.T @ r)
