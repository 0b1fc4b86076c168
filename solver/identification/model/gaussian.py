"""A Gaussian by a root of its covariance, which stays a covariance whatever is done to it."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from .blocks import submatrix

CHECK = "MUKCA_CHECK_COVARIANCES"
"""Environment variable that turns :func:`check` on, as tests and benchmarks do."""
ROUNDING = 1e-9
"""No eigenvalue of a correlation matrix is further below zero, if only rounding is the reason."""
NOTHING = 1e-13
"""Eigenvalue below which a correlation matrix shows rounding alone."""


@dataclass(frozen=True, eq=False)
class Gaussian:
    """Of n unknowns, mu + R z with z standard normal, so that R R^T is their covariance.

    No operation takes one covariance from another: rounding may leave less than nothing there.
    """

    mean: np.ndarray
    """mu, shape (n,)."""
    root: np.ndarray
    """R, shape (n, r)."""

    @staticmethod
    def of(mean: np.ndarray, covariance: np.ndarray) -> "Gaussian":
        """Return the Gaussian of a covariance, less what rounding alone has put into it."""
        variances = np.diag(covariance).clip(min=0)
        unit = np.sqrt(variances)
        scale = np.divide(1, unit, out=np.zeros_like(unit), where=unit > 0)
        correlations = scale[:, None] * covariance * scale
        values, axes = np.linalg.eigh(correlations)
        lengths = np.sqrt(values.clip(min=0))
        return Gaussian(mean, unit[:, None] * axes * lengths)

    @staticmethod
    def of_precision(mean: np.ndarray, precision: np.ndarray) -> "Gaussian":
        """Return the Gaussian of a precision P whose rows have different units."""
        scale = 1 / np.sqrt(np.diag(precision))
        scaled = scale[:, None] * precision * scale
        values, axes = np.linalg.eigh(scaled)
        values = values.clip(min=NOTHING * values[-1])
        lengths = 1 / np.sqrt(values)
        return Gaussian(mean, scale[:, None] * axes * lengths)

    @staticmethod
    def averaged(parts: Sequence["Gaussian"], shares: Sequence[float]) -> "Gaussian":
        """Return mean and spread of a mixture, in which each part has a share."""
        means = np.array([part.mean for part in parts])
        mean = np.array(shares) @ means
        roots: list[np.ndarray] = []
        for part, share in zip(parts, shares, strict=True):
            offset = part.mean - mean
            spread = np.column_stack([offset, part.root])
            roots.append(share**0.5 * spread)
        return Gaussian(mean, np.concatenate(roots, axis=1))

    @staticmethod
    def independent(parts: Sequence["Gaussian"]) -> "Gaussian":
        """Return the Gaussian of the unknowns of several, part after part."""
        mean = np.concatenate([part.mean for part in parts])
        roots: list[np.ndarray] = []
        begin = 0
        for part in parts:
            end = begin + len(part.mean)
            rows = slice(begin, end)
            embedded = part.embedded(rows, len(mean))
            roots.append(embedded.root)
            begin = end
        return Gaussian(mean, np.concatenate(roots, axis=1))

    @cached_property
    def covariance(self) -> np.ndarray:
        """R R^T, shape (n, n)."""
        return self.root @ self.root.T

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviation of each unknown, shape (n,)."""
        return np.linalg.norm(self.root, axis=1)

    def marginal(self, rows: np.ndarray | slice) -> "Gaussian":
        """Return the Gaussian of some unknowns alone."""
        return Gaussian(self.mean[rows], self.root[rows])

    def embedded(self, rows: np.ndarray | slice, size: int) -> "Gaussian":
        """Return the Gaussian of more unknowns, the others being zero."""
        mean = np.zeros(size)
        mean[rows] = self.mean
        root = np.zeros((size, self.root.shape[1]))
        root[rows] = self.root
        return Gaussian(mean, root)

    def conditioned(
        self,
        slopes: np.ndarray,
        errors: np.ndarray,
        count: Literal[1, -1] = 1,
    ) -> "Gaussian":
        """Return it where errors e + A (x - mu) were seen, each with a standard deviation of 1.

        With W = A R = U s V^T, the root becomes R (1 + V ((1 + s^2)^(-1/2) - 1) V^T) (Andrews
        1968). A count of -1 takes back errors that it was conditioned on before, by -s^2.
        """
        W = slopes @ self.root
        U, s, Vt = np.linalg.svd(W, full_matrices=False)
        precisions = 1 + count * s**2
        shares = 1 / precisions.clip(min=NOTHING)
        across = self.root @ Vt.T
        pulls = shares * s * (U.T @ errors)
        shrinkage = across * (np.sqrt(shares) - 1)
        mean = self.mean - count * across @ pulls
        root = self.root + shrinkage @ Vt
        return Gaussian(mean, root)


def check(covariance: np.ndarray) -> None:
    """Raise AssertionError where :data:`CHECK` is set, unless a matrix is a covariance.

    What is held has no variance; all other variances are positive, and no eigenvalue of their
    correlation matrix is below minus :data:`ROUNDING`.
    """
    if CHECK not in os.environ:
        return
    assert np.isfinite(covariance).all(), "a covariance is not finite"
    some = np.any(covariance != 0, axis=1)
    matrix = submatrix(covariance, some)
    variances = np.diag(matrix)
    assert (variances > 0).all(), f"a variance is {variances.min()}"
    unit = 1 / np.sqrt(variances)
    correlations = unit[:, None] * matrix * unit
    shifted = correlations + ROUNDING * np.eye(len(unit))
    try:
        np.linalg.cholesky(shifted)
    except np.linalg.LinAlgError:
        eigenvalue = np.linalg.eigvalsh(shifted)[0] - ROUNDING
        message = f"a correlation matrix has the eigenvalue {eigenvalue:.3g}"
        raise AssertionError(message) from None
