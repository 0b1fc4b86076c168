"""Evidence of explanations of residuals that are linear in all unknowns, in closed form.

Residuals are r = B x + A u + e of standard Gaussian x, u, and C = sigma^2 I + B B^T in
:func:`.log_bayes_factor`.
"""

from itertools import combinations_with_replacement

import numpy as np

from ...bayes.model import log_bayes_factor
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
        self._root, self._whitening = share**0.5, whitening
        white = self._root * self._white(slice(0, len(r)), np.column_stack([r, B]))
        self.r, slopes = white[:, 0], white[:, 1:]
        self.count = share * len(r)
        d2, V = np.linalg.eigh(slopes.T @ slopes)
        self._d2, self._B = d2.clip(min=0.0), slopes @ V
        self._b = self._B.T @ self.r
        self._rr = float(self.r @ self.r)
        volumes = np.ones(1) if whitening is None else np.linalg.det(whitening)
        self._volume = share * float(np.log(volumes).sum())

    def _white(self, rows: slice, values: np.ndarray) -> np.ndarray:
        """Return values in some rows, shape (R, n), in units in which samples are noisy alike."""
        if self._whitening is None or not values.size or rows.start >= 3 * len(self._whitening):
            return values
        W = self._whitening[rows.start // 3 : rows.stop // 3]
        of_samples = W @ values[: 3 * len(W)].reshape(len(W), 3, -1)
        return np.vstack([of_samples.reshape(3 * len(W), -1), values[3 * len(W) :]])

    def log_likelihood(self, sigma: np.ndarray) -> np.ndarray:
        """Return ln p(r) without any further column for each noise, shape (L,)."""
        s2 = sigma**2
        ahead = self._d2 + s2[:, None]
        squares = self._rr - np.sum(self._b**2 / ahead, axis=1)
        spread = np.sum(np.log(ahead / s2[:, None]), axis=1)
        return self._volume - 0.5 * (self.count * np.log(2 * np.pi * s2) + spread + squares / s2)

    def trials(self, smallest: float, largest: float, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Return noises to try, up to beyond the likeliest without further columns, and ln p(r)."""
        trials = np.geomspace(smallest, largest, count)
        base = self.log_likelihood(trials)
        last = int(np.argmax(base)) + 2
        return trials[:last], base[:last]

    def log_ratios(self, block: Block, sigma: np.ndarray) -> np.ndarray:
        """Return ln p(r | candidate) - ln p(r) by noise, width and candidate, shape (L, W, C)."""
        M, g, gain = self._reduced(block, sigma)
        widths = np.array(block.widths)[:, None, None]
        factors = gain[:, None] + log_bayes_factor(M[:, None], g[:, None], widths)
        return factors + block.bonus - np.log(len(widths))

    def chi_square(self, block: Block, sigma: float) -> float:
        """Return by how much a block's first candidate lowers chi-square, by its widest prior."""
        first = block.only([0])
        M, g, gain = self._reduced(first, np.array([sigma]))
        mean, _ = _posterior(M[0, 0], g[0, 0], max(block.widths))
        return float(g[0, 0] @ mean) + 2 * float(gain[0, 0])

    def posterior(self, block: Block, sigma: float) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance of a block's first candidate, by its widest prior."""
        M, g, _ = self._reduced(block.only([0]), np.array([sigma]))
        return _posterior(M[0, 0], g[0, 0], max(block.widths))

    def _reduced(
        self, block: Block, sigma: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return A^T C^-1 A and A^T C^-1 r less what is fixed, and the gain by it, by noise."""
        (C, R, columns), k = block.columns.shape, block.unknowns
        flat = block.columns.transpose(1, 0, 2).reshape(R, C * columns)
        flat = self._white(block.rows, flat)
        T = ((self._root * self._B[block.rows].T) @ flat).reshape(len(self._d2), C, columns)
        A = flat.reshape(R, C, columns).transpose(1, 2, 0)
        s2 = sigma**2
        f = 1 / (self._d2 + s2[:, None])
        products = np.tile(self._root**2 * (A @ A.transpose(0, 2, 1)), (len(f), 1, 1, 1))
        if C == 1:
            products[:, 0] -= np.array([T[:, 0].T @ (one[:, None] * T[:, 0]) for one in f])
        else:
            for a, b in combinations_with_replacement(range(columns), 2):
                products[:, :, a, b] -= f @ (T[:, :, a] * T[:, :, b])
                products[:, :, b, a] = products[:, :, a, b]
        along = ((f * self._b) @ T.reshape(len(T), C * columns)).reshape(len(f), C, columns)
        g = (self._root * (A @ self.r[block.rows]) - along) / s2[:, None, None]
        M = products / s2[:, None, None, None]
        if not block.fixed:
            return M, g, np.zeros((len(sigma), C))
        gain = g[:, :, k] - 0.5 * M[:, :, k, k]
        return M[:, :, :k, :k], g[:, :, :k] - M[:, :, :k, k], gain


def _posterior(M: np.ndarray, g: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and covariance by the information M and the pull g, under a prior's width."""
    information, axes = np.linalg.eigh(M)
    # Where the nuisances explain all, M is a difference of equal numbers.
    variances = 1 / (information.clip(min=0.0) + 1 / width**2)
    covariance: np.ndarray = (axes * variances) @ axes.T
    return covariance @ g, covariance
