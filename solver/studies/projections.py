"""Numbers: matrices less what others span, or of blocks; rows chosen evenly; bisection."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np


def rows_of(columns: np.ndarray) -> np.ndarray:
    """Return columns of samples, shape (N, 3, k), as those of a matrix, shape (3 N, k)."""
    return columns.reshape(-1, columns.shape[-1])


def shifts_of(points: np.ndarray) -> np.ndarray:
    """Return the derivatives of points, shape (N, 3), by a shift of all, shape (N, 3, 3)."""
    return np.tile(np.eye(3), (len(points), 1, 1))


def basis_of(columns: np.ndarray) -> np.ndarray:
    """Return Q, an orthonormal basis of what columns span, of shape (n, k) or (N, 3, k)."""
    Q, _ = np.linalg.qr(rows_of(columns))
    return Q


def outside(
    columns: np.ndarray,
    basis: np.ndarray,
) -> np.ndarray:
    """Return C - Q Q^T C: columns C, shape (n, k), less their part in a span.

    Q has a basis of that, shape (n, r), see :func:`basis_of`.
    """
    along = basis.T @ columns
    return columns - basis @ along


def block_diagonal(blocks: Iterable[np.ndarray]) -> np.ndarray:
    """Return the matrix with blocks of any shapes along its diagonal, zero elsewhere."""
    parts = list(blocks)
    shapes = np.array([part.shape for part in parts])
    matrix = np.zeros(shapes.sum(axis=0))
    begin = np.zeros(2, dtype=int)
    for part in parts:
        end = begin + part.shape
        rows, columns = map(slice, begin, end)
        matrix[rows, columns] = part
        begin = end
    return matrix


def rounded(values: np.ndarray, digits: int) -> tuple[float, ...]:
    """Return numbers of few digits, so that a file is not full of them."""
    return tuple(np.round(values, digits).tolist())


def kernels(q: np.ndarray, lengths: Sequence[float]) -> np.ndarray:
    """Return exp(-|q_i - q_j|^2 / 2 l^2) of N joint positions by each length, shape (L, N, N)."""
    squares = np.sum((q[:, None] - q) ** 2, axis=2)
    return np.exp(-0.5 * squares / np.reshape(lengths, (-1, 1, 1)) ** 2)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Return the unit vector along each vector, shape (..., n); zero for one without a length."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    lengths = np.maximum(lengths, 1e-12)
    return vectors / lengths


def pair_lengths(points: np.ndarray) -> np.ndarray:
    """Return distances between pairs of points, rows 0 and 1, 2 and 3, ..., shape (N,) [m]."""
    offsets = points[1::2] - points[::2]
    return np.linalg.norm(offsets, axis=1)


def evenly(
    count: int,
    most: int,
) -> np.ndarray:
    """Return at most so many of the indices below ``count``, spread evenly."""
    indices = np.linspace(0, count - 1, min(count, most))
    return np.unique(indices.astype(int))


def variances_of(
    rows: np.ndarray,
    covariance: np.ndarray,
) -> np.ndarray:
    """Return r^T Sigma r of each row r, shape (N, n), as (N,)."""
    spread = rows @ covariance
    return np.sum(spread * rows, axis=1)


def bisected(
    is_below: Callable[[np.ndarray], np.ndarray],
    low: np.ndarray,
    high: np.ndarray,
    rounds: int,
) -> np.ndarray:
    """Return the ends of intervals, shape (N,), of values that are below; halved in each round."""
    for _ in range(rounds):
        middle = (low + high) / 2
        below = is_below(middle)
        low = np.where(below, middle, low)
        high = np.where(below, high, middle)
    return high
