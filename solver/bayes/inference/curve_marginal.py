"""Samples' errors with the joint error curves integrated out, at given scales and weights."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..model import sample_degrees, sample_scales
from ..model.effects import kernel
from .curve_prior import CurvePrior
from .linear_samples import LinearSamples, Rest, rest_of
from .state import State

SMALL = 40
"""Rows of half a triangle from which on it is inverted half by half, in a third of the time."""


@dataclass(frozen=True, eq=False)
class CurveFit:
    """A fit to some samples: the errors' covariance M of (A8), and what follows of it.

    M has blocks, 1 of 3 N rows, or N of 3 without curves.
    """

    state: State
    """Around which the samples are linear, with the scales."""
    samples: LinearSamples
    prior: CurvePrior
    weights: np.ndarray
    """w_i, shape (N,)."""

    @cached_property
    def rest(self) -> Rest:
        """Knowledge besides the samples."""
        return rest_of(self.state, len(self.weights) / len(self.state.errors))

    @cached_property
    def degrees(self) -> np.ndarray:
        """Degrees of freedom nu of each sample, shape (N,)."""
        return sample_degrees(self.state.noises, self.samples.sources)

    @cached_property
    def scales(self) -> np.ndarray:
        """C_i, shape (N, 3, 3)."""
        return sample_scales(self.state.noises, self.samples.sources, self.samples.slopes)

    @property
    def blocks(self) -> np.ndarray:
        """C_i / w_i, shape (N, 3, 3)."""
        return self.scales / self.weights[:, None, None]

    @cached_property
    def curves(self) -> tuple[np.ndarray, ...]:
        """See :func:`curve_covariance`."""
        return curve_covariance(self.samples, self.prior)

    @cached_property
    def root(self) -> np.ndarray:
        """See :func:`marginal_root`."""
        return marginal_root(self.blocks, self.curves)

    @cached_property
    def inverse(self) -> np.ndarray:
        """M^-1, as L^-1."""
        return self.root.swapaxes(1, 2) @ self.root

    @cached_property
    def whitened(self) -> np.ndarray:
        """L^-1 [G, a], shape (3 N, d + 1)."""
        return _times(self.root, self.samples.columns)

    @cached_property
    def solved(self) -> np.ndarray:
        """M^-1 [G, a], shape (3 N, d + 1)."""
        return _times(self.root.swapaxes(1, 2), self.whitened)

    @cached_property
    def posterior(self) -> tuple[np.ndarray, np.ndarray]:
        """The unknowns y beside the curves, and their covariance Sigma."""
        return self.rest.posterior(self.whitened.T @ self.whitened)

    @cached_property
    def pulls(self) -> np.ndarray:
        """Errors p = M^-1 (a + G y) in units of their variance, shape (3 N,)."""
        return self.solved @ np.append(self.posterior[0], 1.0)

    @cached_property
    def squares(self) -> np.ndarray:
        """e_i^T C_i^-1 e_i after the fit, shape (N,)."""
        errors = self.blocks @ self.pulls.reshape(-1, 3, 1)
        return np.sum(errors * np.linalg.solve(self.scales, errors), axis=(1, 2))

    @cached_property
    def next_weights(self) -> np.ndarray:
        """The robust weights by these errors, shape (N,)."""
        return (self.degrees + 3) / (self.degrees + self.squares)

    @cached_property
    def known(self) -> np.ndarray:
        """M^-1 G Sigma, shape (3 N, d). With it V = M^-1 - M^-1 G Sigma G^T M^-1."""
        return self.solved[:, :-1] @ self.posterior[1]

    @cached_property
    def projected_blocks(self) -> np.ndarray:
        """Blocks of V, one a sample, shape (N, 3, 3)."""
        n, (count, rows, _) = len(self.weights), self.inverse.shape
        own = self.inverse.reshape(count, rows // 3, 3, rows // 3, 3)
        own = own[:, np.arange(rows // 3), :, np.arange(rows // 3)].reshape(n, 3, 3)
        rest, known = (part.reshape(n, 3, -1) for part in (self.solved[:, :-1], self.known))
        return own - known @ rest.transpose(0, 2, 1)

    def projected(self, columns: np.ndarray) -> np.ndarray:
        """Return V times columns, shape (3 N, columns)."""
        return _times(self.inverse, columns) - self.known @ (self.solved[:, :-1].T @ columns)

    def trace(self, part: np.ndarray) -> float:
        """Return the trace of V times a part of M, shape (3 N, 3 N)."""
        hidden = np.sum(self.known * (part @ self.solved[:, :-1]))
        return float(np.vdot(self.inverse, part) - hidden)

    @property
    def log_determinants(self) -> float:
        """Log |M| - log |Sigma|."""
        sigma = self.posterior[1][np.ix_(self.rest.free, self.rest.free)]
        unit = np.sqrt(np.diag(sigma))
        logs = np.log(unit).sum() + np.log(np.diagonal(self.root, axis1=1, axis2=2)).sum()
        return -float(2 * logs + np.linalg.slogdet(sigma / unit[:, None] / unit)[1])


def marginal_root(blocks: np.ndarray, curves: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return L^-1 of each block L L^T of M, of the samples' blocks and :func:`curve_covariance`."""
    if not curves:
        return inverse_root(blocks)
    M, n = curves[0].copy(), len(blocks)
    M.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)] += blocks
    return inverse_root(M)[None]


def inverse_root(matrix: np.ndarray) -> np.ndarray:
    """Return L^-1 of a positive definite matrix L L^T, or of blocks."""

    def inverse(L: np.ndarray) -> np.ndarray:
        half = L.shape[-1] // 2
        if half < SMALL:
            return np.linalg.inv(L)
        found, a, b = np.zeros_like(L), slice(half), slice(half, None)
        found[a, a], found[b, b] = inverse(L[a, a]), inverse(L[b, b])
        found[b, a] = -found[b, b] @ (L[b, a] @ found[a, a])
        return found

    return inverse(np.linalg.cholesky(matrix))


def _times(matrix: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the product of a matrix, as its blocks, with columns, of shape (3 N, columns)."""
    count, rows, _ = matrix.shape
    product = matrix @ columns.reshape(count, rows, -1)
    return product.reshape(count * rows, -1)


def curve_covariance(samples: LinearSamples, prior: CurvePrior) -> tuple[np.ndarray, ...]:
    """Return the curves' part of M, and its derivative by log l, each of shape (3 N, 3 N).

    There is no derivative for curves of which a prior tells, and neither without curves.
    """
    if samples.given is not None:
        return (samples.given_covariance,)
    if not prior.amplitude:
        return ()
    S, n = samples.slopes, len(samples.readings)
    of_angles = prior.amplitude**2 * np.stack(kernel(samples.distances, prior.length))
    if samples.count > 1:
        of_angles *= (samples.arms[:, None] == samples.arms)[:, None]
    across = of_angles[:, :, :, None] * np.ascontiguousarray(S.T)
    parts = S @ across.reshape(2, n, -1, 3 * n)
    K, by_length = parts.reshape(2, 3 * n, 3, n).swapaxes(2, 3).reshape(2, 3 * n, 3 * n)
    return K, by_length
