"""Recordings as a linear model: residuals of samples about a fit, then those of known distances.

Nuisance parameters are the centres, the geometry, the effects beyond it, and the caliper.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...identification.effects import BACKLASH
from . import nuisances
from .loaded_arm import LoadedArm
from .nuisances import DISTANCE_WEIGHT

COARSE = 4e-4
"""Arms that repeat worse than this have gears with play [m]."""


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
        """Where each sample has the place of its seat, Phi(q) - R y, shape (N, 3) [m]."""
        return self.linear.points - self.offsets

    @cached_property
    def residuals(self) -> np.ndarray:
        """Residuals of samples, then of distances, shape (3 N + K,) [m]."""
        # beside those at the nominal model
        by_fitted = self.linear.by_unknowns[:, :, : len(self.x)]
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
        samples = self.all_samples
        lengths = self.all_lengths
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
        ]
        if self.zeros or self.noise > COARSE:
            play = nuisances.of_play(self.by_joints, self.sockets, self.noise)
            parts.append((samples, play))
        parts += [(rows, columns) for rows, columns, _ in self.explained]
        return self.stacked(parts)

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
        J = self.linear.by_joints * (self.play / self.noise)
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
