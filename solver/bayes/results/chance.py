"""Distance between two calibrations of one arm, and how far chance alone would set them apart.

An estimate is off the truth x by -M (x - mu) + G e: M = Sigma P^-1 is the share that the prior has
in it, and G the gain of the measurements' errors e. So two estimates of one x differ by a Gaussian
with the covariance

    (M_a - M_b) P (M_a - M_b)^T + N_a + N_b - X - X^T,    N = Sigma - M P M^T

where X is by the errors that both share: those of samples that both were made of, and that of the
base's length as measured.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...data import IDENTITY, common_covariance, distance_covariance, kabsch
from ...results import Apart
from ..inference import Posterior
from ..model import block_matrix, prior_covariance
from .projections import outside
from .uncertainty import covariance_of

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
        return points, J.reshape(-1, J.shape[2])

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

    def columns(self, names: Sequence[str]) -> np.ndarray:
        """Return the columns of D of some unknowns, zero for those that the model lacks."""
        return _spread_out(self.linear[1], self.posterior.model.names, names)

    def prior(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """Return D M and P of some unknowns, shapes (3 N, names) and (names, names).

        Error curves count as if data alone told of them.
        """
        size = self.posterior.model.size
        free = [g for g in self.posterior.groups if g.width and g.length is None]
        precision = block_matrix(size, ((g.members, g.precision(g.width)) for g in free))
        columns = [names.index(name) for name in self.posterior.model.names]
        P = block_matrix(len(names), [(columns, prior_covariance(free, size))])
        shares = self.spread[:, :size] @ precision
        return _spread_out(shares, self.posterior.model.names, names), P

    @cached_property
    def whitened(self) -> np.ndarray:
        """D G C^1/2 of the samples in sockets, shape (samples, 3, 3 N).

        With J the derivatives of a sample's ball, E those of its socket's centre, C = L L^T its
        noise and w its weight, a sample's part is w^1/2 L^-1 (J - E) Sigma D^T.
        """
        posterior = self.posterior
        data = posterior.data
        rows = np.flatnonzero(data.sockets >= 0)
        samples = data.positions[rows], data.torques[rows], data.clocks[rows]
        _, J, by_joints = posterior.linearise(*samples)
        size = J.shape[2]
        of_centres = self.spread[:, size:].reshape(len(self.spread), -1, 3)
        at_sockets = of_centres[:, data.sockets[rows]].transpose(1, 2, 0)
        shifts = J @ self.spread[:, :size].T - at_sockets
        L = np.linalg.cholesky(posterior.noise.as_gaussian(by_joints))
        weights = np.sqrt(posterior.weights[rows])[:, None, None]
        return weights * np.linalg.solve(L, shifts)

    @cached_property
    def by_lengths(self) -> np.ndarray:
        """D G of the K measured distances, shape (3 N, K).

        With U the derivatives of the distances by the centres, and C the covariance by which they
        are measured, it is D Sigma U^T C^-1.
        """
        lengths = self.posterior.data.known
        centres = self.posterior.centres
        of_centres = self.spread[:, self.posterior.model.size :].reshape(-1, len(centres), 3)
        slopes = np.zeros((len(of_centres), len(lengths)))
        for k, length in enumerate(lengths):
            offset = centres[length.second] - centres[length.first]
            shifts = of_centres[:, length.second] - of_centres[:, length.first]
            slopes[:, k] = shifts @ offset / np.linalg.norm(offset)
        if not lengths:
            return slopes
        return slopes @ np.linalg.inv(distance_covariance(lengths))


def _spread_out(
    columns: np.ndarray, names_of_columns: Sequence[str], names: Sequence[str]
) -> np.ndarray:
    """Return columns of some unknowns as those of others, zero for unknowns that they lack."""
    place = {name: i for i, name in enumerate(names)}
    result = np.zeros((len(columns), len(names)))
    result[:, [place[name] for name in names_of_columns]] = columns
    return result


def difference_covariance(a: Estimate, b: Estimate) -> np.ndarray:
    """Return the covariance by chance of the difference of predicted balls, (3 N, 3 N) [m^2].

        D [(M_a - M_b) P (M_a - M_b)^T + N_a + N_b] D^T - X - X^T

    over the unknowns of either. A model that lacks an unknown holds it at the prior's mean, so M
    is 1 of it there. P of an unknown that both have is the mean of theirs.
    """
    of_a = a.posterior.model.names
    of_b = b.posterior.model.names
    names = [*of_a, *(name for name in of_b if name not in of_a)]
    shares_a, P_a = a.prior(names)
    shares_b, P_b = b.prior(names)
    noise = a.covariance - shares_a @ P_a @ shares_a.T
    noise += b.covariance - shares_b @ P_b @ shares_b.T
    in_a = np.isin(names, of_a)
    in_b = np.isin(names, of_b)
    shares_a += b.columns(names) * ~in_a
    shares_b += a.columns(names) * ~in_b
    in_both = np.outer(in_a & in_b, in_a & in_b)
    P = (P_a + P_b) * np.where(in_both, 0.5, 1.0)
    differences = shares_a - shares_b
    S = common_covariance(a.posterior.data.known, b.posterior.data.known)
    X = _shared_by_samples(a, b) + a.by_lengths @ S @ b.by_lengths.T
    return differences @ P @ differences.T + noise - X - X.T


def _still(covariance: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return a covariance of N points without their rigid motions, symmetric, (3 N, 3 N)."""
    Q = np.linalg.qr(IDENTITY.slopes(points).reshape(-1, 6))[0]
    inner = outside(outside(covariance, Q).T, Q)
    return (inner + inner.T) / 2


def _mean_distances(covariance: np.ndarray) -> np.ndarray:
    """Return the mean length of N offsets in random draws of them, shape (DRAWS,) [m]."""
    variances, axes = np.linalg.eigh(covariance)
    root = axes * np.sqrt(variances.clip(min=0))
    white = np.random.default_rng(0).standard_normal((len(root), DRAWS))
    offsets = (root @ white).reshape(-1, 3, DRAWS)
    return np.linalg.norm(offsets, axis=1).mean(axis=0)


def _shared_by_samples(a: Estimate, b: Estimate) -> np.ndarray:
    """Return the part of X by samples that both were made of."""
    first = _keys(a.posterior)
    second = _keys(b.posterior)
    rows = [i for i, key in enumerate(first) if key in second]
    rows_of_second = [second.index(first[i]) for i in rows]
    u = a.whitened[rows]
    v = b.whitened[rows_of_second]
    return u.reshape(-1, u.shape[2]).T @ v.reshape(-1, v.shape[2])


def _keys(posterior: Posterior) -> list[tuple[float, ...]]:
    """Return the joint positions of samples in sockets, as numbers that can be compared."""
    rows = posterior.data.positions[posterior.data.sockets >= 0]
    return [tuple(row) for row in rows.round(SAME_DIGITS).tolist()]


def apart_by_chance(a: Estimate, b: Estimate, *, follows: bool = False) -> Apart:
    """Return how far the balls of two calibrations are apart at poses, and how far by chance.

    A ball in a socket does not show the base frame, so a rigid motion of it is taken out. If one is
    the prior of the other, ``follows``, the second holds all that the first does. Then the
    covariance of their difference is the difference of their covariances.
    """
    A = a.linear[0]
    B = b.linear[0]
    gaps = np.linalg.norm(kabsch(B, A).apply(B) - A, axis=1)
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
