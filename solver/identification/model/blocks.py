"""Square matrices of unknowns, taken apart and put together by the rows of some of them."""

from collections.abc import Iterable, Sequence

import numpy as np

Rows = np.ndarray | Sequence[int]
"""Some of n unknowns, as indices or a mask of shape (n,)."""


def submatrix(matrix: np.ndarray, rows: Rows) -> np.ndarray:
    """Return the rows and columns of some unknowns: of a covariance, that of these alone."""
    every_row = np.arange(len(matrix))
    indices = every_row[rows]
    return matrix[np.ix_(indices, indices)]


def block_matrix(size: int, blocks: Iterable[tuple[Rows, np.ndarray]]) -> np.ndarray:
    """Return a matrix with blocks at the rows and columns of some unknowns, zero elsewhere."""
    every_row = np.arange(size)
    matrix = np.zeros((size, size))
    for rows, block in blocks:
        indices = every_row[rows]
        matrix[np.ix_(indices, indices)] = block
    return matrix


def inverse_root(matrix: np.ndarray) -> np.ndarray:
    """Return R, lower triangular, with R^T R the inverse of a covariance or precision.

    The unknowns may have different units. The diagonal of R tells the determinant: that of the
    inverse is the product of its squares.

    Raises:
        numpy.linalg.LinAlgError: The matrix is not positive definite.
    """
    variances = np.diag(matrix)
    if not (variances > 0).all():
        raise np.linalg.LinAlgError("a variance is not positive")
    unit = 1 / np.sqrt(variances)
    correlations = unit[:, None] * matrix * unit
    factor = np.linalg.cholesky(correlations)
    return np.linalg.inv(factor) * unit


def scaled_inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverse by its :func:`inverse_root`: symmetric, and no variance below zero."""
    root = inverse_root(matrix)
    return root.T @ root


def log_determinant(matrix: np.ndarray) -> float:
    """Return ln |matrix| of a covariance or precision, whose unknowns may have different units."""
    diagonal = np.diag(inverse_root(matrix))
    return -2 * float(np.log(diagonal).sum())
