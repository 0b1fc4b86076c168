"""A Gaussian by a root of its covariance, which stays a covariance whatever is done to it."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate
from typing import Literal

import numpy as np

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
        unit = np.sqrt(np.diag(covariance).clip(min=0))
        scale = np.divide(1, unit, out=np.zeros_like(unit), where=unit > 0)
        values, axes = np.linalg.eigh(covariance * scale[:, None] * scale)
        return Gaussian(mean, unit[:, None] * axes * np.sqrt(values.clip(min=0)))

    @staticmethod
    def of_precision(mean: np.ndarray, precision: np.ndarray) -> "Gaussian":
        """Return the Gaussian of a precision P whose rows have different units."""
        scale = 1 / np.sqrt(np.diag(precision))
        values, axes = np.linalg.eigh(precision * scale[:, None] * scale)
        values = values.clip(min=NOTHING * values[-1])
        return Gaussian(mean, scale[:, None] * axes / np.sqrt(values))

    @staticmethod
    def averaged(parts: Sequence["Gaussian"], shares: Sequence[float]) -> "Gaussian":
        """Return mean and spread of a mixture, in which each part has a share."""
        pairs = [*zip(parts, shares, strict=True)]
        mean = np.sum([share * part.mean for part, share in pairs], axis=0)
        roots = [
            share**0.5 * np.column_stack([part.mean - mean, part.root])
            for part, share in pairs
        ]
        return Gaussian(mean, np.concatenate(roots, axis=1))

    @staticmethod
    def independent(parts: Sequence["Gaussian"]) -> "Gaussian":
        """Return the Gaussian of the unknowns of several, part after part."""
        mean = np.concatenate([part.mean for part in parts])
        bounds = [*accumulate((len(part.mean) for part in parts), initial=0)]
        rows = map(slice, bounds, bounds[1:])
        roots = [
            p.embedded(r, len(mean)).root for p, r in zip(parts, rows, strict=True)
        ]
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
        root = np.zeros((size, self.root.shape[1]))
        mean[rows], root[rows] = self.mean, self.root
        return Gaussian(mean, root)

    def conditioned(
        self, slopes: np.ndarray, errors: np.ndarray, count: Literal[1, -1] = 1
    ) -> "Gaussian":
        """Return it where errors e + A (x - mu) were seen, each with a standard deviation of 1.

        With W = A R = U s V^T, the root becomes R (1 + V ((1 + s^2)^(-1/2) - 1) V^T) (Andrews
        1968). A count of -1 takes back errors that it was conditioned on before, by -s^2.
        """
        U, s, Vt = np.linalg.svd(slopes @ self.root, full_matrices=False)
        shares = 1 / (1 + count * s**2).clip(min=NOTHING)
        across = self.root @ Vt.T
        mean = self.mean - count * across @ (shares * s * (U.T @ errors))
        return Gaussian(mean, self.root + (across * (np.sqrt(shares) - 1)) @ Vt)


def check(covariance: np.ndarray) -> None:
    """Raise AssertionError where :data:`CHECK` is set, unless a matrix is a covariance.

    What is held has no variance; all other variances are positive, and no eigenvalue of their
    correlation matrix is below minus :data:`ROUNDING`.
    """
    if CHECK not in os.environ:
        return
    variances = np.diag(covariance)
    some = np.flatnonzero(np.any(covariance != 0, axis=1))
    assert np.isfinite(covariance).all(), "a covariance is not finite"
    assert (variances[some] > 0).all(), f"a variance is {variances[some].min()}"
    unit = 1 / np.sqrt(variances[some])
    correlations = covariance[some][:, some] * unit[:, None] * unit
    shifted = correlations + ROUNDING * np.eye(len(some))
    try:
        np.linalg.cholesky(shifted)
    except np.linalg.LinAlgError:
        eigenvalue = np.linalg.eigvalsh(shifted)[0] - ROUNDING
        raise AssertionError(
            f"a correlation matrix has the eigenvalue {eigenvalue:.3g}"
        ) from None
