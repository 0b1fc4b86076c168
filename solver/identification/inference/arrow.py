"""The inverse of a curvature whose unknowns fall into cells, by Schur's complement."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..model import Gaussian, block_matrix, inverse_root, log_determinant, submatrix


@dataclass(frozen=True, eq=False)
class Form:
    """Which of n unknowns a curvature H couples: H + F F^T couples no two cells."""

    cells: Sequence[np.ndarray] = ()
    """Indices of the unknowns of each cell, which are all free."""
    shared: np.ndarray | None = None
    """F, by the errors that measured distances share, shape (n, g), zero beside cells; None for
    no such errors."""


class Arrow:
    """The inverse of what is free of a curvature H, shape (n, n), zero for what is held.

    The cells c are eliminated one by one. With d for all other unknowns and the shared errors,

        S = H_dd - sum_c H_dc H_cc^-1 H_cd      H^-1 = G S^-1 G^T + sum_c H_cc^-1

    where G is 1 for d, and -H_cc^-1 H_cd for c. The shared errors' rows of G are not needed.

    Raises:
        numpy.linalg.LinAlgError: A part of it is not positive definite.
    """

    def __init__(self, H: np.ndarray, free: np.ndarray, form: Form = Form()) -> None:
        n = len(H)
        F = np.zeros((n, 0)) if form.shared is None else form.shared
        alone = free.copy()
        for cell in form.cells:
            alone[cell] = False
        dense = np.flatnonzero(alone)
        G = np.zeros((n, len(dense) + F.shape[1]))
        S = np.eye(G.shape[1])
        d = np.arange(len(dense))
        S[: len(d), : len(d)] = submatrix(H, dense)
        G[dense, d] = 1.0
        self.cells: list[tuple[np.ndarray, np.ndarray]] = []
        """Of each cell its unknowns, and R_c with R_c^T R_c = H_cc^-1."""
        for cell in form.cells:
            rows = H[cell]
            R = inverse_root(rows[:, cell] + F[cell] @ F[cell].T)
            scaled = R @ np.hstack([rows[:, dense], F[cell]])
            S -= scaled.T @ scaled
            G[cell] = -R.T @ scaled
            self.cells.append((cell, R))
        self.G, self.S = G, S
        self._root = inverse_root(S) @ G.T

    @property
    def inverse(self) -> np.ndarray:
        """H^-1, shape (n, n): symmetric, and no variance below zero."""
        inverse = self._root.T @ self._root
        for cell, R_c in self.cells:
            inverse[np.ix_(cell, cell)] += R_c.T @ R_c
        return inverse

    @property
    def log_determinant(self) -> float:
        """Return ln |H| of what is free."""
        of_cells = (np.log(np.diag(R)).sum() for _, R in self.cells)
        return log_determinant(self.S) - 2 * float(sum(of_cells))

    def spread(self, B: np.ndarray) -> np.ndarray:
        """Return B_k H^-1 B_k^T for K matrices, shape (K, d, n), as (K, d, d)."""
        root = B @ self._root.T
        spread = root @ root.transpose(0, 2, 1)
        touched = B.any(axis=(0, 1))
        for cell, R in self.cells:
            if np.any(touched[cell]):
                root = B[:, :, cell] @ R.T
                spread += root @ root.transpose(0, 2, 1)
        return spread

    def gaussian(self, mean: np.ndarray) -> Gaussian:
        """Return the Gaussian of covariance H^-1 about a mean, shape (n,)."""
        of_dense = Gaussian.of_precision(np.zeros(len(self.S)), self.S)
        parts = [self.G @ of_dense.root]
        if self.cells:
            of_cells = block_matrix(len(mean), [(cell, R.T) for cell, R in self.cells])
            parts.append(of_cells[:, np.concatenate([cell for cell, _ in self.cells])])
        return Gaussian(mean, np.hstack(parts))
