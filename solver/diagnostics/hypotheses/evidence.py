"""Evidence of explanations of residuals that are linear in all unknowns, in closed form.

Residuals are r = B x + A u + e of standard Gaussian x, u, and C = sigma^2 I + B B^T in
:func:`.log_bayes_factor`.
"""

import numpy as np

from ...identification.model import log_bayes_factor
from .kinds import Block

INDEPENDENT = 0.5
"""Share of the errors that count as independent: those in similar poses are correlated."""


class LinearEvidence:
    """Residuals r, shape (R,) [m], and derivatives B by nuisances in their widths, (R, n).

    ``whitening`` is the inverse root of the samples' covariances, (N, 3, 3); None for all alike.
    """

    def __init__(
        self,
        r: np.ndarray,
        B: np.ndarray,
        share: float = INDEPENDENT,
        whitening: np.ndarray | None = None,
    ) -> None:
        self._root = share**0.5
        self._whitening = whitening
        columns = np.column_stack([r, B])
        white = self._white(slice(0, len(r)), columns)
        self.r = white[:, 0]
        slopes = white[:, 1:]
        self.count = share * len(r)
        squares, axes = np.linalg.eigh(slopes.T @ slopes)
        self._d2 = squares.clip(min=0.0)
        self._D = slopes @ axes
        self._along = self._D.T @ self.r
        self._square = float(self.r @ self.r)
        self._log_volume = 0.0
        if whitening is not None:
            log_volume = float(np.log(np.linalg.det(whitening)).sum())
            self._log_volume = share * log_volume

    def _white(
        self,
        rows: slice,
        values: np.ndarray,
    ) -> np.ndarray:
        """Return values in some rows, shape (R, n), in units in which samples are noisy alike.

        Only a share of the errors counts.
        """
        values = self._root * values
        if self._whitening is None:
            return values
        first = rows.start // 3
        end = rows.stop // 3
        W = self._whitening[first:end]
        N, n = len(W), values.shape[1]
        of_samples, of_distances = np.split(values, [3 * N])
        white = W @ of_samples.reshape(N, 3, n)
        return np.vstack([white.reshape(3 * N, n), of_distances])

    def log_likelihood(self, sigma: np.ndarray) -> np.ndarray:
        """Return ln p(r) without any further column for each noise, shape (L,)."""
        s2 = sigma**2
        variances = self._d2 + s2[:, None]
        explained = np.sum(self._along**2 / variances, axis=1)
        chi_square = (self._square - explained) / s2
        spread = np.log(variances / s2[:, None]).sum(axis=1)
        noise = self.count * np.log(2 * np.pi * s2)
        return self._log_volume - 0.5 * (noise + spread + chi_square)

    def trials(
        self,
        smallest: float,
        largest: float,
        count: int,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return noises to try, up to beyond the likeliest without further columns, shape (L,) [m].

        And ln p(r) without these for each of them.
        """
        sigma = np.geomspace(smallest, largest, count)
        logs = self.log_likelihood(sigma)
        end = int(np.argmax(logs)) + 2
        return sigma[:end], logs[:end]

    def log_ratios(
        self,
        block: Block,
        sigma: np.ndarray,
    ) -> np.ndarray:
        """Return ln p(r | candidate) - ln p(r) by noise, width and candidate, shape (L, W, C)."""
        M, g = self._information(block, sigma)
        if block.fixed:
            shifts = g - 0.5 * M[..., 0]
            return shifts[:, None, :, 0] + block.bonus
        widths = np.array(block.widths)[:, None, None]
        factors = log_bayes_factor(M[:, None], g[:, None], widths)
        return factors + block.bonus - np.log(len(widths))

    def chi_square(
        self,
        block: Block,
        sigma: float,
    ) -> float:
        """Return by how much a block's only candidate lowers chi-square, by its widest prior."""
        _, g = self._information(block, np.array([sigma]))
        mean, _ = self.posterior(block, sigma)
        return float(g[0, 0] @ mean)

    def posterior(
        self,
        block: Block,
        sigma: float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance of a block's only candidate, by its widest prior."""
        M, g = self._information(block, np.array([sigma]))
        information, axes = np.linalg.eigh(M[0, 0])
        # Where the nuisances explain all, M is a difference of equal numbers.
        information = information.clip(min=0.0)
        precision = information + max(block.widths) ** -2
        covariance = (axes / precision) @ axes.T
        return covariance @ g[0, 0], covariance

    def _information(
        self,
        block: Block,
        sigma: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return A^T C^-1 A, shape (L, C, k, k), and A^T C^-1 r, (L, C, k), of L noises.

        With D = B V, whose columns are at right angles and have the lengths d,
        C^-1 = (1 - D (d^2 + sigma^2)^-1 D^T) / sigma^2.
        """
        C, R, k = block.columns.shape
        by_rows = block.columns.transpose(1, 0, 2)
        white = self._white(block.rows, by_rows.reshape(R, C * k))
        by_rows = white.reshape(R, C, k)
        A = by_rows.transpose(1, 2, 0)
        along = self._D[block.rows].T @ white
        DA = along.reshape(len(along), C, k)
        s2 = sigma**2
        shares = 1 / (self._d2 + s2[:, None])
        if C == 1:
            T = DA[:, 0]
            products = [T.T @ (share[:, None] * T) for share in shares]
            explained = np.array(products)[:, None]
        else:
            pairs = DA[..., :, None] * DA[..., None, :]
            explained = np.tensordot(shares, pairs, 1)
        squares = A @ A.swapaxes(1, 2) - explained
        of_residuals = np.tensordot(shares * self._along, DA, 1)
        pulls = A @ self.r[block.rows] - of_residuals
        M = squares / s2[:, None, None, None]
        g = pulls / s2[:, None, None]
        return M, g
