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

import numpy as np

from ...data import IDENTITY, common_covariance, distance_covariance, kabsch
from ...results import Apart
from ..inference import Posterior
from ..model import block_matrix, prior_covariance
from .projections import basis_of, outside, rows_of
from .uncertainty import covariance_of
from .whitening import samples_in_sockets

DRAWS = 1000
SAME_DIGITS = 6
"""Digits to which joint positions of one sample agree [rad], [m]."""
BAND = 0.95


@dataclass(frozen=True)
class Estimate:
    """Predictions of a calibration at poses, and the sources of their errors."""

    posterior: Posterior
    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    moments: np.ndarray
    """Moments that hold the joints, shape (N, 3 m) [N m]."""

    @cached_property
    def linear(self) -> tuple[np.ndarray, np.ndarray]:
        """Balls, shape (N, 3) [m], and their derivatives D by the unknowns, shape (3 N, size)."""
        points, J, _ = self.posterior.linearise(self.q, self.moments)
        return points, rows_of(J)

    @cached_property
    def spread(self) -> np.ndarray:
        """D Sigma, Sigma with the sockets' centres, shape (3 N, n)."""
        size = self.posterior.model.size
        Sigma = self.posterior.covariance[:size].copy()
        Sigma[:, :size] = covariance_of(self.posterior)
        return self.linear[1] @ Sigma

    @property
    def covariance(self) -> np.ndarray:
        """D Sigma D^T, the covariance of the predicted balls, shape (3 N, 3 N) [m^2]."""
        D = self.linear[1]
        return self.spread[:, : D.shape[1]] @ D.T

    @property
    def by_prior(self) -> tuple[np.ndarray, np.ndarray]:
        """D M and P of the model's unknowns, shapes (3 N, size) and (size, size).

        P is at the widths over which Sigma was averaged: beside a found one, which may be nothing,
        Sigma P^-1 is no share. Error curves count as if data alone told of them.
        """
        size = self.posterior.model.size
        groups = [g for g in self.posterior.groups if g.width and g.length is None]
        P = prior_covariance(groups, size, widened=True)
        precisions = [(g.members, g.precision(g.deviation)) for g in groups]
        shares = self.spread[:, :size] @ block_matrix(size, precisions)
        return shares, P

    @property
    def recorded(self) -> list[tuple[float, ...]]:
        """Joint positions of the samples in sockets, so that equal ones compare equal."""
        data = self.posterior.data
        rows = data.positions[data.sockets >= 0].round(SAME_DIGITS)
        return list(map(tuple, rows.tolist()))

    @property
    def by_samples(self) -> np.ndarray:
        """D G C^1/2 of the samples in sockets, shape (samples, 3, 3 N).

        With A a sample's whitened derivatives and w its weight, its part is w^1/2 A Sigma D^T.
        """
        slopes = samples_in_sockets(self.posterior).slopes
        weights = self.posterior.weights[self.posterior.data.sockets >= 0]
        shares = np.sqrt(weights)[:, None, None]
        return shares * (slopes @ self.spread.T)

    @property
    def by_lengths(self) -> np.ndarray:
        """D G of the K measured distances, shape (3 N, K).

        With U the derivatives of the distances by the centres, and C the covariance by which they
        are measured, it is D Sigma U^T C^-1.
        """
        lengths = self.posterior.data.known
        centres = self.posterior.centres
        first = [length.first for length in lengths]
        second = [length.second for length in lengths]
        offsets = centres[second] - centres[first]
        directions = offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
        of_centres = self.spread[:, self.posterior.model.size :]
        by_centres = of_centres.reshape(len(self.spread), -1, 3)
        shifts = by_centres[:, second] - by_centres[:, first]
        slopes = np.einsum("nki,ki->nk", shifts, directions)
        return slopes @ np.linalg.inv(distance_covariance(lengths))


def difference_covariance(a: Estimate, b: Estimate) -> np.ndarray:
    """Return the covariance by chance of the difference of predicted balls, (3 N, 3 N) [m^2].

        D [(M_a - M_b) P (M_a - M_b)^T + N_a + N_b] D^T - X - X^T

    over the unknowns of either. A model that lacks an unknown holds it at the prior's mean, so M
    is 1 of it there. P of an unknown that both have is the mean of theirs.
    """
    names_of_a = a.posterior.model.names
    names_of_b = b.posterior.model.names
    names_of_both = dict.fromkeys([*names_of_a, *names_of_b])
    place = {name: i for i, name in enumerate(names_of_both)}
    models_with = np.zeros(len(place))
    P = np.zeros((len(place), len(place)))
    differences = np.zeros((len(a.spread), len(place)))
    noise = np.zeros((len(a.spread), len(a.spread)))
    for sign, estimate, other in ((1, a, b), (-1, b, a)):
        names = estimate.posterior.model.names
        lacking = ~np.isin(names, other.posterior.model.names)
        shares, prior = estimate.by_prior
        indices = [place[name] for name in names]
        models_with[indices] += 1
        P[np.ix_(indices, indices)] += prior
        differences[:, indices] += sign * (shares - lacking * estimate.linear[1])
        noise += estimate.covariance - shares @ prior @ shares.T
    in_both = models_with == 2
    P[np.ix_(in_both, in_both)] /= 2
    X = _by_shared_errors(a, b)
    return differences @ P @ differences.T + noise - X - X.T


def _by_shared_errors(a: Estimate, b: Estimate) -> np.ndarray:
    """Return X, by samples that both were made of and by bases that both stood on, (3 N, 3 N)."""
    numbers: dict[tuple[float, ...], int] = {}
    for i, q in enumerate(b.recorded):
        numbers.setdefault(q, i)  # one each: a posture may have been recorded twice
    pairs = [(i, numbers[q]) for i, q in enumerate(a.recorded) if q in numbers]
    same_a, same_b = np.reshape(pairs, (-1, 2)).astype(int).T
    by_samples = rows_of(a.by_samples[same_a]).T @ rows_of(b.by_samples[same_b])
    S = common_covariance(a.posterior.data.known, b.posterior.data.known)
    return by_samples + a.by_lengths @ S @ b.by_lengths.T


def apart_by_chance(a: Estimate, b: Estimate, *, follows: bool = False) -> Apart:
    """Return how far the balls of two calibrations are apart at poses, and how far by chance.

    A ball in a socket does not show the base frame, so a rigid motion of it is taken out. If one is
    the prior of the other, ``follows``, the second holds all that the first does. Then the
    covariance of their difference is the difference of their covariances.
    """
    A = a.linear[0]
    B = b.linear[0]
    moved = kabsch(B, A).apply(B)
    gaps = np.linalg.norm(moved - A, axis=1)
    if follows:
        covariance = a.covariance - b.covariance
        covariance *= np.sign(np.trace(covariance))
    else:
        covariance = difference_covariance(a, b)
    drawn = _mean_distances(_still(covariance, A))
    value = float(gaps.mean())
    return Apart(
        value=value,
        chance=float(drawn.mean()),
        deviation=float(drawn.std()),
        largest=float(np.quantile(drawn, BAND)),
        probability=float(np.mean(drawn >= value)),
    )


def _still(covariance: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return a covariance of N points without their rigid motions, symmetric, (3 N, 3 N)."""
    Q = basis_of(IDENTITY.slopes(points))
    inner = outside(outside(covariance, Q).T, Q)
    return (inner + inner.T) / 2


def _mean_distances(covariance: np.ndarray) -> np.ndarray:
    """Return the mean length of N offsets in random draws of them, shape (DRAWS,) [m]."""
    variances, axes = np.linalg.eigh(covariance)
    root = axes * np.sqrt(variances.clip(min=0))
    white = np.random.default_rng(0).standard_normal((len(root), DRAWS))
    offsets = (root @ white).reshape(-1, 3, DRAWS)
    return np.linalg.norm(offsets, axis=1).mean(axis=0)
