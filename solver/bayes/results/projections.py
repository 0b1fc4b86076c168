"""Matrices: less what others span, and of blocks; and rows chosen evenly."""

from collections.abc import Iterable

import numpy as np


def outside(columns: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Return C - Q Q^T C: columns C, shape (n, k), less their part in a span.

    Q has an orthonormal basis of that, shape (n, r), as columns.
    """
    return columns - basis @ (basis.T @ columns)


def block_diagonal(blocks: Iterable[np.ndarray]) -> np.ndarray:
    """Return the matrix with blocks of any shapes along its diagonal, zero elsewhere."""
    parts = list(blocks)
    shapes = np.array([part.shape for part in parts])
    ends = np.cumsum(shapes, axis=0)
    matrix = np.zeros(ends[-1])
    for part, (row, column), (below, right) in zip(parts, ends - shapes, ends, strict=True):
        matrix[row:below, column:right] = part
    return matrix


def evenly(count: int, most: int) -> np.ndarray:
    """Return at most so many of the indices below ``count``, spread evenly."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))
