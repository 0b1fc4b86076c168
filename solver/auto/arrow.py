"""The curvature of the objective, as its blocks that are not zero, and its inverse.

A sample depends on x, on the frames, and on the centre of its own socket. So the centres know of
each other only by x and the frames, and by what was measured between them:

    H = [ A  C^T ]  +  B^T B         B = [ B_x  B_m ]
        [ C   D  ]

A belongs to x and the frames; D has a 3 x 3 block for each socket, and is zero elsewhere; B has a
row for each of the K measured numbers. The centres are eliminated first, socket by socket (Schur
complement; Boyd and Vandenberghe, Convex Optimization, appendix A.5.5), what was measured by the
formula of Woodbury:

    L L^T = I + B_m D^-1 B_m^T       V = D^-1 B_m^T L^-T       (D + B_m^T B_m)^-1 = D^-1 - V V^T
    T = C + B_m^T B_x                X = (D^-1 - V V^T) T      S = A + B_x^T B_x - T^T X

    H^-1 = [  S^-1      -S^-1 X^T                  ]
           [ -X S^-1    D^-1 - V V^T + X S^-1 X^T  ]

So a step takes time and memory in proportion to the number of sockets, not to its cube and square.
"""

from dataclasses import dataclass, replace

import numpy as np

__all__ = ["Arrow", "Inverse"]


@dataclass(frozen=True)
class Arrow:
    """H, of d unknowns x and frames, then of S socket centres: n in all."""

    dense: np.ndarray
    """A, shape (d, d)."""
    across: np.ndarray
    """C, shape (3 S, d)."""
    own: np.ndarray
    """The blocks of D, shape (S, 3, 3)."""
    known: np.ndarray
    """B, shape (K, n)."""

    def plus(self, dense: np.ndarray) -> "Arrow":
        """Return the sum with a matrix of x and the frames alone, shape (d, d)."""
        return replace(self, dense=self.dense + dense)

    def times(self, vector: np.ndarray) -> np.ndarray:
        """Return H v, shape (n,)."""
        d = len(self.dense)
        x, m = vector[:d], vector[d:]
        of_x = self.dense @ x + self.across.T @ m
        of_m = self.across @ x + _times(self.own, m[:, None])[:, 0]
        return np.concatenate([of_x, of_m]) + self.known.T @ (self.known @ vector)

    def inverse(self, free: np.ndarray) -> "Inverse":
        """Return the inverse of a positive definite H whose rows have different units.

        Args:
            free: Which of x and the frames count, shape (d,); the others are zero in the inverse.
        """
        d = len(free)
        B_x, B_m = self.known[:, :d][:, free], self.known[:, d:]
        inverse = np.linalg.inv(self.own)
        G = _times(inverse, B_m.T)
        L = np.linalg.cholesky(np.eye(len(B_m)) + B_m @ G)
        V = np.linalg.solve(L, G.T).T
        T = self.across[:, free] + B_m.T @ B_x
        X = np.zeros_like(self.across)
        X[:, free] = _times(inverse, T) - V @ (V.T @ T)
        A = self.dense[np.ix_(free, free)] + B_x.T @ B_x
        scale = 1 / np.sqrt(np.diag(A))
        units = scale[:, None] * scale
        S = (A - T.T @ X[:, free]) * units
        dense = np.zeros_like(self.dense)
        dense[np.ix_(free, free)] = np.linalg.inv(S) * units
        logs = [np.linalg.slogdet(S)[1], 2 * np.log(np.diag(L)).sum(), -2 * np.log(scale).sum()]
        log_determinant = float(sum(logs) + np.linalg.slogdet(self.own)[1].sum())
        return Inverse(dense, inverse, X, V, log_determinant)


@dataclass(frozen=True)
class Inverse:
    """H^-1, as the parts that it is made of."""

    dense: np.ndarray
    """S^-1, the covariance of x and the frames, shape (d, d)."""
    apart: np.ndarray
    """The blocks of D^-1, shape (S, 3, 3)."""
    X: np.ndarray
    """Shape (3 S, d)."""
    V: np.ndarray
    """Shape (3 S, K)."""
    log_determinant: float
    """log |H| of what is free."""

    @property
    def across(self) -> np.ndarray:
        """The covariance of the centres with x and the frames, shape (S, 3, d)."""
        return -(self.X @ self.dense).reshape(-1, 3, len(self.dense))

    @property
    def own(self) -> np.ndarray:
        """The covariance of each centre, shape (S, 3, 3)."""
        X, V = (part.reshape(-1, 3, part.shape[1]) for part in (self.X, self.V))
        return self.apart - V @ V.swapaxes(1, 2) - self.across @ X.swapaxes(1, 2)

    def times(self, vector: np.ndarray) -> np.ndarray:
        """Return H^-1 v, shape (n,)."""
        d = len(self.dense)
        x, m = vector[:d], vector[d:]
        x = self.dense @ (x - self.X.T @ m)
        m = _times(self.apart, m[:, None])[:, 0] - self.V @ (self.V.T @ m)
        return np.concatenate([x, m - self.X @ x])

    def whole(self) -> np.ndarray:
        """Return all of it, shape (n, n)."""
        across = -self.X @ self.dense
        centres = -across @ self.X.T - self.V @ self.V.T
        for k, block in enumerate(self.apart):
            centres[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += block
        return np.block([[self.dense, across.T], [across, centres]])


def _times(blocks: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the product of a block diagonal matrix with columns, shape (3 S, columns)."""
    return (blocks @ columns.reshape(len(blocks), 3, columns.shape[1])).reshape(columns.shape)
