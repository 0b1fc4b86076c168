"""Distance between two calibrations of one arm, and how far chance alone would set them apart.

An estimate is off the truth x by -M (x - mu) + G e: M = Sigma P^-1 is the share that the prior has
in it, and G the gain of the measurements' errors e. So two estimates of one x differ by a Gaussian
with the covariance

    (M_a - M_b) P (M_a - M_b)^T + N_a + N_b - X - X^T,    N = Sigma - M P M^T

where X is by the errors that both share: those of samples that both were made of, and that of the
base's length as measured.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..identification.data import (
    IDENTITY,
    Samples,
    common_covariance,
    distance_covariance,
    kabsch,
)
from ..identification.inference import Posterior
from ..identification.model import block_matrix, prior_covariance
from ..results import Apart
from .base_errors import KnownLengths
from .projections import basis_of, outside, rows_of
from .uncertainty import covariance_of
from .whitening import samples_in_sockets

DRAWS = 1000
SAME_DIGITS = 6
"""Digits to which joint positions of one sample agree [rad], [m]."""
BAND = 0.95


class LinearBalls(NamedTuple):
    """N balls, linear in a model's unknowns."""

    points: np.ndarray
    """Shape (N, 3) [m]."""
    slopes: np.ndarray
    """D, their derivatives, shape (3 N, size)."""


class PriorShare(NamedTuple):
    """The share of a prior in an estimate."""

    shares: np.ndarray
    """D M, shape (3 N, size)."""
    covariance: np.ndarray
    """P of the model's unknowns, shape (size, size)."""


@dataclass(frozen=True)
class Estimate:
    """Predictions of a calibration at poses, and the sources of their errors."""

    posterior: Posterior
    poses: Samples

    @cached_property
    def linear(self) -> LinearBalls:
        """The balls, linear in the unknowns."""
        points, J, _ = self.posterior.linearise(self.poses)
        return LinearBalls(points, rows_of(J))

    @cached_property
    def spread(self) -> np.ndarray:
        """D Sigma, Sigma with the sockets' centres, shape (3 N, n)."""
        size = self.posterior.model.size
        Sigma = self.posterior.covariance[:size].copy()
        Sigma[:, :size] = covariance_of(self.posterior)
        return self.linear.slopes @ Sigma

    @property
    def covariance(self) -> np.ndarray:
        """D Sigma D^T, the covariance of the predicted balls, shape (3 N, 3 N) [m^2]."""
        D = self.linear.slopes
        of_unknowns = self.spread[:, : D.shape[1]]
        return of_unknowns @ D.T

    @cached_property
    def by_prior(self) -> PriorShare:
        """D M and P.

        P is at the widths over which Sigma was averaged: beside a found one, which may be nothing,
        Sigma P^-1 is no share. Error curves count as if data alone told of them.
        """
        size = self.posterior.model.size
        groups = [g for g in self.posterior.groups if g.width and g.length is None]
        blocks = [(g.members, g.precision(g.deviation)) for g in groups]
        precision = block_matrix(size, blocks)
        return PriorShare(
            shares=self.spread[:, :size] @ precision,
            covariance=prior_covariance(groups, size, widened=True),
        )

    @property
    def by_noise(self) -> np.ndarray:
        """D N D^T, shape (3 N, 3 N) [m^2]."""
        shares, prior = self.by_prior
        return self.covariance - shares @ prior @ shares.T

    @property
    def recorded(self) -> list[tuple[float, ...]]:
        """Joint positions of the samples in sockets, so that equal ones compare equal."""
        data = self.posterior.data
        return [*map(tuple, data.q[data.seated].round(SAME_DIGITS).tolist())]

    @property
    def by_samples(self) -> np.ndarray:
        """D G C^1/2 of the samples in sockets, shape (samples, 3, 3 N).

        With A a sample's whitened derivatives and w its weight, its part is w^1/2 A Sigma D^T.
        """
        slopes = samples_in_sockets(self.posterior).slopes
        weights = self.posterior.weights[self.posterior.data.seated]
        roots = np.sqrt(weights)[:, None, None]
        return roots * (slopes @ self.spread.T)

    @property
    def by_lengths(self) -> np.ndarray:
        """D G of the K measured distances, shape (3 N, K).

        With U the derivatives of the distances by the centres, and C the covariance by which they
        are measured, it is D Sigma U^T C^-1.
        """
        of_centres = self.spread[:, self.posterior.model.size :]
        slopes = of_centres @ KnownLengths.of(self.posterior).slopes.T
        return slopes @ np.linalg.inv(distance_covariance(self.posterior.data.known))


def difference_covariance(
    a: Estimate,
    b: Estimate,
) -> np.ndarray:
    """Return the covariance by chance of the difference of predicted balls, (3 N, 3 N) [m^2].

        D [(M_a - M_b) P (M_a - M_b)^T + N_a + N_b] D^T - X - X^T

    over the unknowns of either. A model that lacks an unknown holds it at the prior's mean, so M
    is 1 of it there. P of an unknown that both have is the mean of theirs.
    """
    names_of_a = a.posterior.model.names
    names_of_b = b.posterior.model.names
    names_of_both = np.array([*dict.fromkeys([*names_of_a, *names_of_b])])
    of_a = _share_in_difference(a, b, names_of_both)
    of_b = _share_in_difference(b, a, names_of_both)
    priors = of_a.covariance + of_b.covariance
    in_a = np.isin(names_of_both, names_of_a)
    in_b = np.isin(names_of_both, names_of_b)
    in_both = np.ix_(in_a & in_b, in_a & in_b)
    priors[in_both] /= 2
    differences = of_a.shares - of_b.shares
    by_prior = differences @ priors @ differences.T
    X = _by_shared_errors(a, b)
    return by_prior + a.by_noise + b.by_noise - X - X.T


def _share_in_difference(
    estimate: Estimate,
    other: Estimate,
    names: np.ndarray,
) -> PriorShare:
    """Return D M and P over the unknowns of two estimates, by their names.

    Of an unknown that the other model lacks, and so holds, D M is less by D.
    """
    own_names = np.array(estimate.posterior.model.names)
    shares, prior = estimate.by_prior
    is_lacking = ~np.isin(own_names, other.posterior.model.names)
    held_by_other = is_lacking * estimate.linear.slopes
    places = (own_names[:, None] == names).astype(float)
    return PriorShare((shares - held_by_other) @ places, places.T @ prior @ places)


def _by_shared_errors(
    a: Estimate,
    b: Estimate,
) -> np.ndarray:
    """Return X, by samples that both were made of and by bases that both stood on, (3 N, 3 N)."""
    # one each: a posture may have been recorded twice
    numbers = {q: i for i, q in reversed([*enumerate(b.recorded)])}
    pairs = [(i, numbers[q]) for i, q in enumerate(a.recorded) if q in numbers]
    same_a, same_b = np.reshape(pairs, (-1, 2)).astype(int).T
    by_samples = rows_of(a.by_samples[same_a]).T @ rows_of(b.by_samples[same_b])
    S = common_covariance(a.posterior.data.known, b.posterior.data.known)
    return by_samples + a.by_lengths @ S @ b.by_lengths.T


def apart_by_chance(
    a: Estimate,
    b: Estimate,
    *,
    follows: bool,
) -> Apart:
    """Return how far the balls of two calibrations are apart at poses, and how far by chance.

    A ball in a socket does not show the base frame, so a rigid motion of it is taken out. If one is
    the prior of the other, ``follows``, the second holds all that the first does. Then the
    covariance of their difference is the difference of their covariances.
    """
    A, B = a.linear.points, b.linear.points
    gaps = kabsch(B, A).apply(B) - A
    value = float(np.linalg.norm(gaps, axis=1).mean())
    if follows:
        covariance = a.covariance - b.covariance
        covariance *= np.sign(np.trace(covariance))
    else:
        covariance = difference_covariance(a, b)
    distances = _mean_distances(_still(covariance, A))
    return Apart(
        value=value,
        chance=float(distances.mean()),
        deviation=float(distances.std()),
        largest=float(np.quantile(distances, BAND)),
        probability=float(np.mean(distances >= value)),
    )


def _still(
    covariance: np.ndarray,
    points: np.ndarray,
) -> np.ndarray:
    """Return a covariance of N points without their rigid motions, symmetric, (3 N, 3 N)."""
    Q = basis_of(IDENTITY.slopes(points))
    inner = outside(outside(covariance, Q).T, Q)
    return (inner + inner.T) / 2


def _mean_distances(covariance: np.ndarray) -> np.ndarray:
    """Return the mean length of N offsets in random draws of them, shape (DRAWS,) [m]."""
    variances, axes = np.linalg.eigh(covariance)
    deviations = np.sqrt(variances.clip(min=0))
    root = axes * deviations
    generator = np.random.default_rng(0)
    white = generator.standard_normal((len(root), DRAWS))
    offsets = (root @ white).reshape(-1, 3, DRAWS)
    distances = np.linalg.norm(offsets, axis=1)
    return distances.mean(axis=0)
