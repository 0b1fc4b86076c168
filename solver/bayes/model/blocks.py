"""Square matrices of unknowns, taken apart and put together by the rows of some of them."""

from collections.abc import Iterable, Sequence

import numpy as np

Rows = np.ndarray | Sequence[int]
"""Some of n unknowns, as indices or a mask of shape (n,)."""


def submatrix(matrix: np.ndarray, rows: Rows) -> np.ndarray:
    """Return the rows and columns of some unknowns: of a covariance, that of these alone."""
    indices = np.arange(len(matrix))[rows]
    return matrix[np.ix_(indices, indices)]


def block_matrix(size: int, blocks: Iterable[tuple[Rows, np.ndarray]]) -> np.ndarray:
    """Return a matrix with blocks at the rows and columns of some unknowns, zero elsewhere."""
    matrix = np.zeros((size, size))
    for rows, block in blocks:
        indices = np.arange(size)[rows]
        matrix[np.ix_(indices, indices)] = block
    return matrix
