"""Evidence of errors beside noise of uncertain size, and of parts that a model lacks.

Errors y are Gaussian with the covariance n^2 C + S: noise C of the fit's shape, and what else is
known to change them, S. A part that the model lacks adds m^2 K to it.

Samples are linear in all unknowns about the fit. With derivatives J of the model's unknowns,
derivatives B by the places of sockets and frames, noise C, and a pattern of columns A and mean
square m^2, errors y are::

    y ~ N(0, n^2 C + J S J^T + B B^T + m^2 A A^T)

Of samples held out S is the posterior covariance. Those trained on are compared beside all that the
unknowns can explain: S is their prior covariance, made wider, and y is taken about the prior mean.
The odds of a pattern are the evidence averaged over m > 0 and n, against that with m = 0.
"""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from ..identification.inference import Posterior
from ..identification.model import probabilities, student_weights
from .projections import block_diagonal, rows_of
from .uncertainty import covariance_of

NOISES = np.geomspace(0.3, 1.5, 8) ** 2
"""n^2, by the noise of the fit, which holds part of what the model lacks."""
NOISE_DEVIATION = 0.5
"""Standard deviation of log n by the prior."""


class Part(NamedTuple):
    """A part A A^T beside a background: W = L_n^-1 A along the axes of V diag(d) V^T = W^T W."""

    d: np.ndarray
    """Shape (n, k)."""
    b: np.ndarray
    """V^T W^T z of the whitened errors z, shape (n, k)."""
    V: np.ndarray
    """Shape (n, k, k)."""


class Background(NamedTuple):
    """R errors without any part that the model lacks, for each n^2 of :data:`NOISES`."""

    basis: np.ndarray
    """U^T G^-1 with C = G G^T and G^-1 S G^-T = U diag(s) U^T, shape (R, R)."""
    scales: np.ndarray
    """(n^2 + s)^-1/2, so that L_n^-1 = diag(scales) U^T G^-1 whitens n^2 C + S, shape (n, R)."""
    white: np.ndarray
    """z = L_n^-1 y, shape (n, R)."""
    logs: np.ndarray
    """-1/2 |z|^2 - log det L_n and the logarithm of the prior of n, shape (n,)."""

    @classmethod
    def of(
        cls,
        y: np.ndarray,
        C: np.ndarray,
        S: np.ndarray,
    ) -> "Background":
        """Return that of errors y, shape (R,)."""
        G = np.linalg.cholesky(C)
        inverse = np.linalg.inv(G)
        s, U = np.linalg.eigh(inverse @ S @ inverse.T)
        basis = U.T @ inverse
        scales = 1 / np.sqrt(NOISES[:, None] + s.clip(min=0))
        white = scales * (basis @ y)
        squares = np.sum(white**2, axis=1)
        log_volume = np.log(np.diag(inverse)).sum()
        log_volumes = log_volume + np.log(scales).sum(axis=1)
        prior = np.square(np.log(NOISES) / 2 / NOISE_DEVIATION)
        logs = log_volumes - 0.5 * (squares + prior)
        return cls(basis, scales, white, logs)

    def part(self, A: np.ndarray) -> Part:
        """Return the part of columns A, shape (R, k)."""
        along_basis = self.basis @ A
        count = A.shape[1]
        d, b = np.zeros((2, len(NOISES), count))
        V = np.zeros((len(NOISES), count, count))
        for n, scale in enumerate(self.scales):
            W = scale[:, None] * along_basis
            d[n], V[n] = np.linalg.eigh(W.T @ W)
            b[n] = self.white[n] @ W @ V[n]
        return Part(d.clip(min=0.0), b, V)

    def with_part(
        self,
        part: Part,
        sizes: np.ndarray,
    ) -> np.ndarray:
        """Return the logarithms of the evidence with a part, for each n and m^2 of sizes, (m,).

        A part adds

            1/2 sum_i [m^2 b_i^2 / (1 + m^2 d_i) - log(1 + m^2 d_i)]
        """
        m2 = sizes[:, None]
        variances = 1 + m2 * part.d[:, None]
        explained = m2 * part.b[:, None] ** 2 / variances
        gains = np.sum(explained - np.log(variances), axis=2)
        return self.logs[:, None] + 0.5 * gains


WIDE = 5.0
"""Factor on the widths of the priors beside which samples trained on are compared."""
SIZES = np.geomspace(0.05, 4.0, 16) ** 2
"""m^2, by the mean square of the noise."""


class PatternRows(NamedTuple):
    """Samples of some placements."""

    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    errors: np.ndarray
    """Errors about their sockets, or in their frames, shape (N, 3) [m]."""
    by_joints: np.ndarray
    """Derivatives of the balls by the joints, shape (N, 3, m)."""
    balls: np.ndarray
    """Shape (N, 3) [m]."""
    time: np.ndarray
    """From 0 at a placement's first sample to 1 at its last, shape (N,)."""
    placement: np.ndarray
    """Index, shape (N,)."""
    seats: np.ndarray
    """B, shape (3 N, k) [m]."""


Slopes = tuple[Posterior, np.ndarray]
"""J, derivatives of a placement's balls by the unknowns of a posterior, shape (N, 3, n)."""
EvidenceOf = Callable[[Posterior, PatternRows, Sequence[Slopes]], "PatternEvidence"]


def of_held_out(
    posterior: Posterior,
    rows: PatternRows,
    slopes: Sequence[Slopes],
) -> "PatternEvidence":
    """Return the evidence of patterns beside what posteriors leave open that have not seen them.

    Samples of one posterior follow one another; those of several count as independent.
    """
    y = rows.errors.ravel()
    blocks: list[np.ndarray] = []
    for _, group in groupby(slopes, key=lambda pair: id(pair[0])):
        (unaware, *_), parts = zip(*group, strict=True)
        J = np.concatenate([rows_of(part) for part in parts])
        blocks.append(J @ covariance_of(unaware) @ J.T)
    return PatternEvidence(posterior, rows, y, block_diagonal(blocks))


def of_trained(
    posterior: Posterior,
    rows: PatternRows,
    slopes: Sequence[Slopes],
) -> "PatternEvidence":
    """Return the evidence of patterns beside all that the model's unknowns can explain."""
    J = np.concatenate([rows_of(part) for _, part in slopes])
    mean = np.zeros(len(posterior.x))
    changes = np.zeros((len(J), len(J)))
    for group in posterior.groups:
        mean[group.members] = group.mean
        columns = J[:, group.members]
        prior = group.covariance(group.width)
        changes += WIDE**2 * (columns @ prior @ columns.T)
    y = rows.errors.ravel() - J @ (posterior.x - mean)
    return PatternEvidence(posterior, rows, y, changes)


class PatternEvidence:
    """Evidence of patterns in errors y, shape (3 N,) [m], beside other changes J S J^T of them."""

    def __init__(
        self,
        posterior: Posterior,
        rows: PatternRows,
        y: np.ndarray,
        changes: np.ndarray,
    ) -> None:
        noise = posterior.noise
        normal = noise.as_gaussian(rows.by_joints)
        precisions = np.linalg.inv(normal)
        squares = np.einsum("ni,nij,nj->n", rows.errors, precisions, rows.errors)
        # The farther a sample is, the less it counts, as in the fit.
        weights = student_weights(squares, noise.nu).clip(max=1.0)
        C = normal / weights[:, None, None]
        traces = np.trace(C, axis1=1, axis2=2)
        self.deviations: np.ndarray = np.sqrt(traces / 3)
        self._size = float(traces.mean())
        S = changes + rows.seats @ rows.seats.T
        self._beside = Background.of(y, block_diagonal(C), S)

    def of(self, columns: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the logarithm of the odds of a pattern, and its mean, shape (N, 3) [m].

        With d, V and b of its :class:`.Part`, its mean at some n and m is
        A V diag(m^2 / (1 + m^2 d)) b.
        """
        mean_square = max(float(np.sum(columns**2)) / len(columns), 1e-30)
        A = columns * (self._size / 3 / mean_square) ** 0.5
        part = self._beside.part(A)
        logs = self._beside.with_part(part, SIZES)
        weights = probabilities(logs)
        m2 = SIZES[:, None]
        shrunk = m2 / (1 + m2 * part.d[:, None])
        along_axes = np.einsum("nm,nmk,nk->nk", weights, shrunk, part.b)
        mean = A @ np.einsum("njk,nk->j", part.V, along_axes)
        log_count = float(np.log(len(SIZES)))
        log_odds = _log_sum(logs) - log_count - _log_sum(self._beside.logs)
        return log_odds, mean.reshape(-1, 3)


def _log_sum(logs: np.ndarray) -> float:
    return float(np.logaddexp.reduce(logs.ravel()))
