"""Evidence of explanations of residuals that are linear in all unknowns, in closed form.

Residuals r = B x + A u + e with x and u standard Gaussian and e of variance sigma^2 have, beside
those without A, the likelihood

    ln p(r | A) - ln p(r) = - ln det(I + A^T C^-1 A) / 2 + g^T (I + A^T C^-1 A)^-1 g / 2

with C = sigma^2 I + B B^T and g = A^T C^-1 r. One eigendecomposition of B^T B gives it for any
sigma. Errors of samples in poses alike are alike, so only a share of the residuals counts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from .kinds import Block

INDEPENDENT = 0.5
"""Share of the errors that count as independent."""


@dataclass(frozen=True)
class Terms:
    """Products of the candidates of a block with the residuals and the nuisances."""

    T: np.ndarray
    """Nuisances times columns, and times the shift if any, shape (n, C, k or k + 1)."""
    AA: np.ndarray
    """Columns, and the shift, times themselves, shape (C, k + 1, k + 1)."""
    Ar: np.ndarray
    """Columns, and the shift, times residuals, shape (C, k + 1)."""

    def only(self, candidates: Sequence[int]) -> "Terms":
        """Return those of some of the candidates."""
        chosen = list(candidates)
        return Terms(self.T[:, chosen], self.AA[chosen], self.Ar[chosen])


class LinearEvidence:
    """Residuals and nuisances.

    Residuals r have shape (R,) [m]; their derivatives B by the nuisances, each in units of its
    prior's width, (R, n). Only a ``share`` of the errors counts as independent. ``whitening`` is
    the inverse root of each sample's covariance beside the noise's square, shape (N, 3, 3); None
    where all are noisy alike.
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
        left = self._rr - np.sum(self._b**2 / ahead, axis=1)
        spread = np.sum(np.log(ahead / s2[:, None]), axis=1)
        return self._volume - 0.5 * (self.count * np.log(2 * np.pi * s2) + spread + left / s2)

    def terms(self, block: Block) -> Terms:
        """Return the products by which a block's evidence follows for any noise."""
        rows, columns = block.rows, block.columns
        if block.masks is not None:
            return self._of_changes(block, block.masks)
        if block.shift is not None:
            columns = np.concatenate([columns, block.shift[:, :, None]], axis=2)
        C, R, k = columns.shape
        flat = self._root * self._white(rows, columns.transpose(1, 0, 2).reshape(R, C * k))
        T = self._B[rows].T @ flat
        A = flat.reshape(R, C, k).transpose(1, 2, 0)
        return Terms(T.reshape(len(T), C, k), A @ A.transpose(0, 2, 1), A @ self.r[rows])

    def _of_changes(self, block: Block, masks: np.ndarray) -> Terms:
        """Return the products of columns in some samples each, summed over samples by masks."""
        (F, N), (C, _, k) = masks.shape, block.columns.shape
        flat = self._white(block.rows, block.columns.transpose(1, 0, 2).reshape(3 * N, C * k))
        A = self._root * flat.reshape(N, 3, C * k)
        B, r = self._B[block.rows].reshape(N, 3, -1), self.r[block.rows].reshape(N, 3)
        by_candidate = A.reshape(N, 3, C, k).transpose(0, 2, 3, 1)

        def summed(products: np.ndarray, *shape: int) -> np.ndarray:
            return (masks @ products.reshape(N, -1)).reshape(*shape)

        T = summed(B.transpose(0, 2, 1) @ A, F, -1, C, k).transpose(1, 0, 2, 3)
        AA = summed(by_candidate @ by_candidate.transpose(0, 1, 3, 2), F * C, k, k)
        Ar = summed(np.einsum("nick,ni->nck", A.reshape(N, 3, C, k), r), F * C, k)
        return Terms(T.reshape(len(T), F * C, k), AA, Ar)

    def log_ratios(self, block: Block, terms: Terms, sigma: np.ndarray) -> np.ndarray:
        """Return ln p(r | candidate) - ln p(r) by noise, width and candidate, shape (L, W, C)."""
        k = block.columns.shape[2]
        M, g, gain = self._reduced(terms, sigma, k)
        found: list[np.ndarray] = []
        for width in block.widths if k else ():
            N, left, log = np.eye(k) + width**2 * M, width * g, gain
            for i in range(k):  # elimination, of all matrices at once: they are small and many
                pivot, row = N[..., i, i], N[..., i, i + 1 :].copy()
                log = log + 0.5 * (left[..., i] ** 2 / pivot - np.log(pivot))
                share = row / pivot[..., None]
                N[..., i + 1 :, i + 1 :] -= share[..., None] * row[..., None, :]
                left[..., i + 1 :] -= share * left[..., i, None]
            found.append(log)
        found = found or [gain]
        return np.stack(found, axis=1) + block.bonus - np.log(len(found))

    def posterior(
        self, block: Block, sigma: float, terms: Terms | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance of a block's first candidate, by its widest prior."""
        k = block.columns.shape[2]
        M, g, _ = self._reduced(terms or self.terms(block), np.array([sigma]), k)
        tight = 1 / max(block.widths) ** 2
        precision: np.ndarray = tight * np.eye(k) + M[0, 0]
        covariance: np.ndarray = np.linalg.inv(precision)
        return covariance.dot(g[0, 0]), covariance

    def _reduced(
        self, terms: Terms, sigma: np.ndarray, k: int
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return A^T C^-1 A, A^T C^-1 r less the shift, and the gain by it, for each noise."""
        n, C, all_of_them = terms.T.shape
        s2 = sigma**2
        f = 1 / (self._d2 + s2[:, None])
        products = np.empty((len(sigma), C, all_of_them, all_of_them))
        if C == 1:
            T = terms.T[:, 0]
            products[:, 0] = terms.AA[0] - np.array([T.T @ (own[:, None] * T) for own in f])
        else:
            for a, b in combinations_with_replacement(range(all_of_them), 2):
                product = f @ (terms.T[:, :, a] * terms.T[:, :, b])
                products[:, :, a, b] = products[:, :, b, a] = terms.AA[:, a, b] - product
        along = ((f * self._b) @ terms.T.reshape(n, C * all_of_them)).reshape(
            len(f), C, all_of_them
        )
        Ar = (terms.Ar - along) / s2[:, None, None]
        AA = products / s2[:, None, None, None]
        if all_of_them == k:
            return AA, Ar, np.zeros((len(sigma), C))
        gain = Ar[:, :, k] - 0.5 * AA[:, :, k, k]
        return AA[:, :, :k, :k], Ar[:, :, :k] - AA[:, :, :k, k], gain
