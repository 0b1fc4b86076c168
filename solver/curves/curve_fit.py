"""Samples' errors with the joint error curves integrated out, at some scales (A8)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..identification.effects import kernel
from ..identification.inference import NormalEquations, Solution, State
from ..identification.model import sample_degrees, sample_scales, student_weights
from .curve_prior import CurvePrior
from .linear_samples import LinearSamples, equations_of_rest, solution_of_rest


@dataclass(frozen=True, eq=False)
class CurveFit:
    """A fit to N samples by M of (A8), as its blocks: 1 of 3 N rows, or without curves N of 3."""

    state: State
    """Around which the samples are linear, with the scales."""
    samples: LinearSamples
    prior: CurvePrior
    weights: np.ndarray
    """w_i, shape (N,)."""

    @cached_property
    def shift(self) -> np.ndarray:
        """[R, c without e], shape (coefficients, d + 1) [rad]; zero where nothing is given."""
        d, given = self.state.objective.size, self.prior.given
        if given is None:
            return np.zeros((np.prod(self.samples.shape), d + 1))
        return given.shift(self.state.x, d)

    @cached_property
    def columns(self) -> np.ndarray:
        """[G_i, a_i] for e in place of the curves, shape (N, 3, d + 1) [m]."""
        columns = self.samples.columns
        if self.prior.given is None:
            return columns
        by_shift = self.samples.basis @ self.shift
        return columns + by_shift.reshape(columns.shape)

    @cached_property
    def rest(self) -> NormalEquations:
        """See :func:`equations_of_rest`."""
        share = len(self.weights) / len(self.state.errors)
        return equations_of_rest(self.state, share)

    @cached_property
    def degrees(self) -> np.ndarray:
        """Degrees of freedom nu of each sample, shape (N,)."""
        return sample_degrees(self.state.noises, self.samples.sources)

    @cached_property
    def scales(self) -> np.ndarray:
        """C_i, shape (N, 3, 3)."""
        samples = self.samples
        return sample_scales(self.state.noises, samples.sources, samples.slopes)

    @cached_property
    def noise_blocks(self) -> np.ndarray:
        """C_i / w_i, shape (N, 3, 3)."""
        return self.scales / self.weights[:, None, None]

    @cached_property
    def parts_of_noise(self) -> tuple[np.ndarray, ...]:
        """Parts of M by each source's seat and by its joints, as blocks of shape (N, 3, 3)."""
        slopes = self.samples.slopes
        by_joints = slopes @ slopes.swapaxes(1, 2)
        parts: list[np.ndarray] = []
        for k, noise in enumerate(self.state.noises):
            shares = (self.samples.sources == k) / self.weights
            shares = shares[:, None, None]
            parts.append(noise.space**2 * np.eye(3) * shares)
            parts.append(noise.joint**2 * by_joints * shares)
        return tuple(parts)

    @cached_property
    def curves(self) -> tuple[np.ndarray, ...]:
        """The curves' part of M and, unless it is given, its derivative by log l, (3 N, 3 N)."""
        samples, prior = self.samples, self.prior
        if prior.given is not None:
            F = samples.basis
            return (F @ prior.times(F.T),)
        if not prior.amplitude:
            return ()
        S = samples.slopes
        N = len(S)
        kernels = np.stack(kernel(samples.distances, prior.length))  # (2, N, m, N)
        kernels *= prior.amplitude**2
        S_T = np.ascontiguousarray(S.T)
        columns = kernels[:, :, :, None] * S_T  # (2, N, m, 3, N)
        sums = S @ columns.reshape(2, N, -1, 3 * N)  # over the joints
        by_axis = sums.reshape(2, 3 * N, 3, N)
        by_sample = by_axis.swapaxes(2, 3)
        K, by_length = by_sample.reshape(2, 3 * N, 3 * N)
        return K, by_length

    @property
    def has_process(self) -> bool:
        """True if the evidence sets the curves' amplitude and length."""
        return len(self.curves) == 2

    @cached_property
    def blocks(self) -> np.ndarray:
        """M, as its blocks."""
        if not self.curves:
            return self.noise_blocks
        M = self.curves[0].copy()
        _diagonal_blocks(M, len(self.weights))[:] += self.noise_blocks
        return M[None]

    @cached_property
    def inverse(self) -> np.ndarray:
        """M^-1, as its blocks."""
        return np.linalg.inv(self.blocks)

    @cached_property
    def solved(self) -> np.ndarray:
        """M^-1 [G, a], shape (3 N, d + 1)."""
        count, rows, _ = self.inverse.shape
        columns = self.columns.reshape(count, rows, -1)
        solved = self.inverse @ columns
        return solved.reshape(count * rows, -1)

    @cached_property
    def information(self) -> np.ndarray:
        """[G, a]^T M^-1 [G, a], shape (d + 1, d + 1)."""
        columns = self.columns.reshape(self.solved.shape)
        return columns.T @ self.solved

    @cached_property
    def solution(self) -> Solution:
        """The unknowns y beside the curves, and their covariance Sigma."""
        return solution_of_rest(self.state, self.rest, self.information)

    @cached_property
    def pulls(self) -> np.ndarray:
        """Errors p = M^-1 (a + G y) in units of their variance, shape (3 N,)."""
        y = self.solution.change
        return self.solved @ np.append(y, 1.0)

    @cached_property
    def squares(self) -> np.ndarray:
        """e_i^T C_i^-1 e_i after the fit, shape (N,)."""
        pulls = self.pulls.reshape(-1, 3, 1)
        return self.squares_of(self.noise_blocks @ pulls)

    def squares_of(self, errors: np.ndarray) -> np.ndarray:
        """Return e_i^T C_i^-1 e_i of any errors, shape (N, 3, 1)."""
        whitened = np.linalg.solve(self.scales, errors)
        return np.sum(errors * whitened, axis=(1, 2))

    def weights_at(self, y: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Return the robust weights by the errors at [y, 1] and coefficients e, shape (N,)."""
        index, basis = self.samples.coefficients
        shifts = (e[index] * basis).sum(axis=2)
        by_curves = self.samples.slopes @ shifts[..., None]
        beside_curves = self.columns @ y
        errors = beside_curves[..., None] + by_curves
        return student_weights(self.squares_of(errors), self.degrees)

    @cached_property
    def next_weights(self) -> np.ndarray:
        """The robust weights by these errors, shape (N,)."""
        return student_weights(self.squares, self.degrees)

    @cached_property
    def projection(self) -> np.ndarray:
        """V = M^-1 - M^-1 G Sigma G^T M^-1, shape (3 N, 3 N)."""
        by_unknowns = self.solved[:, :-1]
        V = -(by_unknowns @ self.solution.covariance) @ by_unknowns.T
        _diagonal_blocks(V, len(self.inverse))[:] += self.inverse
        return V

    @cached_property
    def projected_blocks(self) -> np.ndarray:
        """Blocks of V, one a sample, shape (N, 3, 3)."""
        return _diagonal_blocks(self.projection, len(self.weights))


def _diagonal_blocks(matrix: np.ndarray, count: int) -> np.ndarray:
    """Return a view of the blocks on the diagonal of a square matrix, (count, size, size)."""
    size = len(matrix) // count
    blocks = matrix.reshape(count, size, count, size)
    return np.einsum("isit->ist", blocks)
