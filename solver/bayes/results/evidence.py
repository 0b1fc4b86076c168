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
    def of(cls, y: np.ndarray, C: np.ndarray, S: np.ndarray) -> "Background":
        """Return that of errors y, shape (R,)."""
        inverse = np.linalg.inv(np.linalg.cholesky(C))
        s, U = np.linalg.eigh(inverse @ S @ inverse.T)
        basis = U.T @ inverse
        scales = 1 / np.sqrt(NOISES[:, None] + s.clip(min=0))
        white = scales * (basis @ y)
        volumes = np.log(scales).sum(axis=1) + np.log(np.diag(inverse)).sum()
        prior = np.square(np.log(NOISES) / 2 / NOISE_DEVIATION)
        squares = np.sum(white**2, axis=1)
        return cls(basis, scales, white, volumes - 0.5 * (squares + prior))

    def whitened(self, A: np.ndarray) -> np.ndarray:
        """Return L_n^-1 A of columns A, shape (R, k), as (n, R, k)."""
        return self.scales[:, :, None] * (self.basis @ A)

    def with_part(
        self, d: np.ndarray, squares: np.ndarray, sizes: np.ndarray
    ) -> np.ndarray:
        """Return the logarithms of the evidence with a part of K, for each n and m^2 of sizes.

        With L_n^-1 K L_n^-T = W W^T, and V diag(d) V^T = W^T W, and b = V^T W^T z, a part adds

            1/2 sum_i [m^2 b_i^2 / (1 + m^2 d_i) - log(1 + m^2 d_i)]

        Args:
            d: Shape (n, k).
            squares: b^2, likewise.
            sizes: m^2, shape (m,).
        """
        m2 = sizes[:, None]
        variances = 1 + m2 * d[:, None]
        gains = m2 * squares[:, None] / variances - np.log(variances)
        return self.logs[:, None] + 0.5 * gains.sum(axis=2)
