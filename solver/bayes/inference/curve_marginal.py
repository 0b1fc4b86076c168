"""Samples' errors with the joint error curves integrated out."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..model.effects import kernel
from .linear_samples import LinearSamples, Rest

SMALL = 40
"""Rows of half a triangle from which on it is inverted half by half, in a third of the time."""


@dataclass(frozen=True)
class CurvePrior:
    """The Gaussian process of all curves."""

    amplitude: float
    """s [rad]; 0 for no curves."""
    length: float
    """l [rad]."""


@dataclass(frozen=True)
class Marginal:
    """The errors' covariance M, and what follows of the unknowns beside the curves."""

    by_rest: np.ndarray
    """M^-1 G, shape (3 N, free)."""
    covariance: np.ndarray
    """Sigma of y, zero for what is held, shape (d, d)."""
    change: np.ndarray
    """y, shape (d,)."""
    pulls: np.ndarray
    """p = M^-1 (a + G y), shape (3 N,): the curves are minus their covariance with the samples,
    times it."""
    free: np.ndarray
    """Which of y are not held, shape (d,)."""
    root: np.ndarray
    """L^-1, with M = L L^T, shape (3 N, 3 N); without curves its blocks, shape (N, 3, 3)."""

    @cached_property
    def inverse(self) -> np.ndarray:
        """M^-1, as L^-1."""
        return self.root.swapaxes(-1, -2) @ self.root

    @cached_property
    def by_rest_known(self) -> np.ndarray:
        """M^-1 G Sigma, shape (3 N, free). With it V = M^-1 - M^-1 G Sigma G^T M^-1."""
        return self.by_rest @ self.covariance[np.ix_(self.free, self.free)]

    @cached_property
    def blocks(self) -> np.ndarray:
        """Blocks of V, one a sample, shape (N, 3, 3)."""
        n = len(self.by_rest) // 3
        own = self.inverse
        if own.ndim == 2:
            own = own.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)]
        rest, known = (part.reshape(n, 3, -1) for part in (self.by_rest, self.by_rest_known))
        return own - known @ rest.transpose(0, 2, 1)

    def projected(self, columns: np.ndarray) -> np.ndarray:
        """Return V times columns, shape (3 N, columns)."""
        return _times(self.inverse, columns) - self.by_rest_known @ (self.by_rest.T @ columns)

    def trace(self, part: np.ndarray) -> float:
        """Return the trace of V times a part of M, shape (3 N, 3 N)."""
        hidden = np.sum(self.by_rest_known * (part @ self.by_rest))
        return float(np.vdot(self.inverse, part) - hidden)

    @property
    def log_determinants(self) -> float:
        """Log |M| - log |Sigma|."""
        unit = np.sqrt(np.diag(self.covariance)[self.free])
        sigma = self.covariance[np.ix_(self.free, self.free)] / unit[:, None] / unit
        scales = np.diagonal(self.root, axis1=-2, axis2=-1)
        logs = np.log(unit).sum() + np.log(scales).sum()
        return -float(2 * logs + np.linalg.slogdet(sigma)[1])


def _inverse_root(matrix: np.ndarray) -> np.ndarray:
    """Return L^-1 of a positive definite matrix L L^T, or of blocks."""

    def inverse(L: np.ndarray) -> np.ndarray:
        half = L.shape[-1] // 2
        if half < SMALL:
            return np.linalg.inv(L)
        found = np.zeros_like(L)
        found[:half, :half], found[half:, half:] = (
            inverse(L[:half, :half]),
            inverse(L[half:, half:]),
        )
        found[half:, :half] = -found[half:, half:] @ (L[half:, :half] @ found[:half, :half])
        return found

    return inverse(np.linalg.cholesky(matrix))


def _times(matrix: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the product of a matrix, or of its blocks, shape (N, 3, 3), with columns."""
    if matrix.ndim == 2:
        return matrix @ columns
    return (matrix @ columns.reshape(len(matrix), 3, -1)).reshape(columns.shape)


def curve_covariance(samples: LinearSamples, prior: CurvePrior) -> tuple[np.ndarray, ...]:
    """Return the curves' part of M, and its derivative by log l, each of shape (3 N, 3 N).

    There is no derivative for curves of which a prior tells, and neither without curves.
    """
    if samples.given is not None:
        return (samples.given_covariance,)
    if not prior.amplitude:
        return ()
    S, n = samples.slopes, len(samples.errors)
    of_angles = prior.amplitude**2 * np.stack(kernel(samples.distances, prior.length))
    if samples.count > 1:
        of_angles *= (samples.arms[:, None] == samples.arms)[:, None]
    across = of_angles[:, :, :, None] * np.ascontiguousarray(S.T)
    parts = S @ across.reshape(2, n, -1, 3 * n)
    K, by_length = parts.reshape(2, 3 * n, 3, n).swapaxes(2, 3).reshape(2, 3 * n, 3 * n)
    return K, by_length


def marginal(
    samples: LinearSamples, curves: tuple[np.ndarray, ...], blocks: np.ndarray, rest: Rest
) -> Marginal:
    """Return what follows of M, by :func:`curve_covariance` and blocks C_i / w_i, (N, 3, 3)."""
    n, d, free = len(blocks), len(rest.free), rest.free
    errors = blocks
    if curves:
        errors = curves[0].copy()
        errors.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)] += blocks
    root = _inverse_root(errors)
    G, a = samples.by_rest.reshape(-1, d)[:, free], samples.errors.ravel()
    along = _times(root, np.concatenate([G, a[:, None]], axis=1))
    solved = _times(root.swapaxes(-1, -2), along)
    WG = solved[:, :-1]
    information = G.T @ WG + rest.precision[np.ix_(free, free)]
    unit = 1 / np.sqrt(np.diag(information))
    H = information * unit[:, None] * unit
    sigma = np.linalg.inv(H) * unit[:, None] * unit
    change, covariance = np.zeros(d), np.zeros((d, d))
    change[free] = -sigma @ (WG.T @ a + rest.gradient[free])
    covariance[np.ix_(free, free)] = sigma
    return Marginal(WG, covariance, change, solved[:, -1] + WG @ change[free], free, root)
