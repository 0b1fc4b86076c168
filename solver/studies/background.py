"""Evidence of errors beside noise of uncertain size, and of parts that a model lacks.

Errors y are Gaussian with the covariance n^2 C + S: noise C of the fit's shape, and what else is
known to change them, S. A part that the model lacks adds m^2 K to it.
"""

from typing import NamedTuple

import numpy as np

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
        variances = NOISES[:, None] + s.clip(min=0)
        scales = 1 / np.sqrt(variances)
        white = scales * (basis @ y)
        squares = np.sum(white**2, axis=1)
        log_volume = np.log(np.diag(inverse)).sum()
        log_volumes = log_volume + np.log(scales).sum(axis=1)
        log_noises = np.log(NOISES) / 2
        prior = np.square(log_noises / NOISE_DEVIATION)
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

    def with_part(self, part: Part, sizes: np.ndarray) -> np.ndarray:
        """Return the logarithms of the evidence with a part, for each n and m^2 of sizes, (m,).

        A part adds

            1/2 sum_i [m^2 b_i^2 / (1 + m^2 d_i) - log(1 + m^2 d_i)]
        """
        m2 = sizes[:, None]
        variances = 1 + m2 * part.d[:, None]
        explained = m2 * part.b[:, None] ** 2 / variances
        terms = explained - np.log(variances)
        gains = 0.5 * terms.sum(axis=2)
        return self.logs[:, None] + gains
