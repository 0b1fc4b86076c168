"""The inverse of a curvature whose unknowns fall into cells, by Schur's complement."""

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..model import Gaussian, inverse_root, log_determinant, submatrix


class Form(NamedTuple):
    """Which of n unknowns a curvature H couples: H + F F^T couples no two cells."""

    cells: Sequence[np.ndarray]
    """Indices of the unknowns of each cell, which are all free."""
    shared: np.ndarray
    """F, by the errors that measured distances share, shape (n, g), zero beside cells."""


class Arrow:
    """The inverse of what is free of a curvature H, shape (n, n), zero for what is held.

    The cells c are eliminated one by one. With d for all other unknowns and the shared errors,

        S = H_dd - sum_c H_dc H_cc^-1 H_cd      H^-1 = G S^-1 G^T + sum_c H_cc^-1

    where G is 1 for d, and -H_cc^-1 H_cd for c. The shared errors' rows of G are not needed.

    Raises:
        numpy.linalg.LinAlgError: A part of it is not positive definite.
    """

    def __init__(
        self, H: np.ndarray, free: np.ndarray, form: Form | None = None
    ) -> None:
        cells, F = form or ((), H[:, :0])
        alone = free.copy()
        for cell in cells:
            alone[cell] = False
        dense = np.flatnonzero(alone)
        G = np.zeros((len(H), len(dense) + F.shape[1]))
        complement = np.eye(G.shape[1])
        d = slice(len(dense))
        G[dense] = complement[d]
        complement[d, d] = submatrix(H, dense)
        self.cells: list[tuple[np.ndarray, np.ndarray]] = []
        """Of each cell its unknowns, and R_c with R_c^T R_c = H_cc^-1."""
        for cell in cells:
            rows = H[cell]
            R = inverse_root(rows[:, cell] + F[cell] @ F[cell].T)
            scaled = R @ np.hstack([rows[:, dense], F[cell]])
            complement -= scaled.T @ scaled
            G[cell] = -R.T @ scaled
            self.cells.append((cell, R))
        self.G, self.S = G, complement

    @cached_property
    def root(self) -> np.ndarray:
        """R with R^T R = G S^-1 G^T, shape (d, n)."""
        return inverse_root(self.S) @ self.G.T

    @property
    def inverse(self) -> np.ndarray:
        """H^-1, shape (n, n): symmetric, and no variance below zero."""
        inverse = self.root.T @ self.root
        for cell, R_c in self.cells:
            inverse[np.ix_(cell, cell)] += R_c.T @ R_c
        return inverse

    @property
    def log_determinant(self) -> float:
        """Return ln |H| of what is free."""
        of_cells = (np.log(np.diag(R)).sum() for _, R in self.cells)
        return log_determinant(self.S) - 2 * float(sum(of_cells))

    def gaussian(self, mean: np.ndarray) -> Gaussian:
        """Return the Gaussian of covariance H^-1 about a mean, shape (n,)."""
        of_dense = Gaussian.of_precision(np.zeros(len(self.S)), self.S)
        ends = np.cumsum([len(self.S), *(len(cell) for cell, _ in self.cells)])
        root = np.zeros((len(mean), ends[-1]))
        root[:, : ends[0]] = self.G @ of_dense.root
        for (cell, R), begin, end in zip(self.cells, ends, ends[1:], strict=False):
            root[cell, begin:end] = R.T
        return Gaussian(mean, root)
