"""Samples' errors with the joint error curves integrated out, and their scales by the evidence."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import (
    Noise,
    log_determinant,
    sample_degrees,
    sample_scales,
    student_weights,
    submatrix,
)
from ..model.effects import kernel
from .curve_prior import CurvePrior
from .laplace import factors_of_bounds, log_evidence_of_scales
from .linear_samples import LinearSamples, posterior_of_rest, priors_of_rest
from .state import State
from .steps import updated_groups, with_tails, without_negligible

SHORTEST, LONGEST = 0.02, 0.2
"""Bounds of the curves' length [rad]."""
STEPS = 30
SETTLED = 0.1
"""Relative change of the scales at which they are found: by a step of Newton, to some 1 %."""
LARGEST_STEP = 1.0
"""Of the logarithm of a scale's square."""
DECIDED = 0.5
"""Number of unknowns that the data decide from which on a group's width is to settle."""


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
        d, curves = self.state.objective.size, self.prior.given
        if curves is not None:
            return curves.shift(self.state.x, d)
        return np.zeros((np.prod(self.samples.shape), d + 1))

    @cached_property
    def columns(self) -> np.ndarray:
        """[G_i, a_i] for e in place of the curves, shape (N, 3, d + 1) [m]."""
        columns = self.samples.columns
        if self.prior.given is None:
            return columns
        return columns + (self.samples.basis @ self.shift).reshape(columns.shape)

    @cached_property
    def rest(self) -> tuple[np.ndarray, np.ndarray]:
        """See :func:`priors_of_rest`."""
        return priors_of_rest(self.state, len(self.weights) / len(self.state.errors))

    @cached_property
    def degrees(self) -> np.ndarray:
        """Degrees of freedom nu of each sample, shape (N,)."""
        return sample_degrees(self.state.noises, self.samples.sources)

    @cached_property
    def scales(self) -> np.ndarray:
        """C_i, shape (N, 3, 3)."""
        return sample_scales(
            self.state.noises, self.samples.sources, self.samples.slopes
        )

    @cached_property
    def parts_of_noise(self) -> tuple[np.ndarray, ...]:
        """Parts of M by each source's seat and by its joints, as blocks of shape (N, 3, 3)."""
        slopes = self.samples.slopes
        by_joints = slopes @ slopes.transpose(0, 2, 1)
        parts: list[np.ndarray] = []
        for k, noise in enumerate(self.state.noises):
            shares = ((self.samples.sources == k) / self.weights)[:, None, None]
            parts.append(noise.space**2 * np.eye(3) * shares)
            parts.append(noise.joint**2 * by_joints * shares)
        return tuple(parts)

    @cached_property
    def curves(self) -> tuple[np.ndarray, ...]:
        """The curves' part of M and, unless it is given, its derivative by log l, (3 N, 3 N)."""
        samples, prior = self.samples, self.prior
        if prior.given is not None:
            return (samples.basis @ prior.times(samples.basis.T),)
        if not prior.amplitude:
            return ()
        S, n = samples.slopes, len(samples.readings)
        of_angles = prior.amplitude**2 * np.stack(
            kernel(samples.distances, prior.length)
        )
        across = of_angles[:, :, :, None] * np.ascontiguousarray(S.T)
        parts = (S @ across.reshape(2, n, -1, 3 * n)).reshape(2, 3 * n, 3, n)
        K, by_length = parts.swapaxes(2, 3).reshape(2, 3 * n, 3 * n)
        return K, by_length

    @cached_property
    def blocks(self) -> np.ndarray:
        """M, as its blocks."""
        blocks = self.scales / self.weights[:, None, None]
        if not self.curves:
            return blocks
        M = self.curves[0].copy()
        _diagonal_blocks(M, len(blocks))[:] += blocks
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
        return (self.inverse @ columns).reshape(count * rows, -1)

    @cached_property
    def information(self) -> np.ndarray:
        """[G, a]^T M^-1 [G, a], shape (d + 1, d + 1)."""
        return self.columns.reshape(self.solved.shape).T @ self.solved

    @cached_property
    def posterior(self) -> tuple[np.ndarray, np.ndarray]:
        """The unknowns y beside the curves, and their covariance Sigma."""
        return posterior_of_rest(self.state, self.rest, self.information)

    @cached_property
    def pulls(self) -> np.ndarray:
        """Errors p = M^-1 (a + G y) in units of their variance, shape (3 N,)."""
        return self.solved @ np.append(self.posterior[0], 1.0)

    @cached_property
    def squares(self) -> np.ndarray:
        """e_i^T C_i^-1 e_i after the fit, shape (N,)."""
        blocks_of_noise = self.scales / self.weights[:, None, None]
        return self.squares_of(blocks_of_noise @ self.pulls.reshape(-1, 3, 1))

    def squares_of(self, errors: np.ndarray) -> np.ndarray:
        """Return e_i^T C_i^-1 e_i of any errors, shape (N, 3, 1)."""
        whitened = np.linalg.solve(self.scales, errors)
        return np.sum(errors * whitened, axis=(1, 2))

    def weights_at(self, y: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Return the robust weights by the errors at [y, 1] and coefficients e, shape (N,)."""
        index, basis = self.samples.places
        shifts: np.ndarray = np.sum(e[index] * basis, axis=2)
        by_curves = self.samples.slopes @ shifts[..., None]
        errors = (self.columns @ y)[..., None] + by_curves
        return student_weights(self.squares_of(errors), self.degrees)

    @cached_property
    def next_weights(self) -> np.ndarray:
        """The robust weights by these errors, shape (N,)."""
        return student_weights(self.squares, self.degrees)

    @cached_property
    def projection(self) -> np.ndarray:
        """V = M^-1 - M^-1 G Sigma G^T M^-1, shape (3 N, 3 N)."""
        unknowns = self.solved[:, :-1]
        V = -(unknowns @ self.posterior[1]) @ unknowns.T
        _diagonal_blocks(V, len(self.inverse))[:] += self.inverse
        return V

    @cached_property
    def projected_blocks(self) -> np.ndarray:
        """Blocks of V, one a sample, shape (N, 3, 3)."""
        return _diagonal_blocks(self.projection, len(self.weights))


def _diagonal_blocks(matrix: np.ndarray, count: int) -> np.ndarray:
    """Return a view of the blocks on the diagonal of a square matrix, (count, size, size)."""
    size = len(matrix) // count
    return np.einsum("isit->ist", matrix.reshape(count, size, count, size))


def log_evidence(fit: CurveFit) -> float:
    """Return the logarithm of the evidence of a fit but for a constant, as in (A6)."""
    state, nu, p = fit.state, fit.degrees, fit.pulls
    (y, _), (precision, gradient) = fit.posterior, fit.rest
    effective = fit.weights * (nu + 3) / (nu + 5)
    sharp = replace(fit, weights=effective)
    terms = [
        -0.5 * float(np.linalg.slogdet(sharp.blocks)[1].sum()),
        0.5 * log_determinant(submatrix(sharp.posterior[1], state.free)),
        -1.5 * float(np.sum(np.log(effective))),
        -0.5 * float(np.sum((nu + 3) * np.log1p(fit.squares / nu))),
        -0.5 * float(y @ precision @ y) - float(gradient @ y),
        -0.5 * sum(float(p @ K @ p) for K in fit.curves[:1]),
        -0.5 * float(state.offset @ state.prior_precision() @ state.offset),
        log_evidence_of_scales(state, fit.samples.sources),
        factors_of_bounds(state, y, sharp.posterior[1])[2],
    ]
    return sum(terms)


def marginalised(fit: CurveFit) -> CurveFit:
    """Return the fit at the scales of highest evidence."""
    samples = fit.samples
    for _ in range(STEPS):
        weights = fit.next_weights
        by_weights = 0.2 * float(np.abs(np.log(weights / fit.weights)).max())
        by_scales, prior, noises = _updated_scales(fit)
        y, covariance = fit.posterior
        x = fit.state.x + y[: len(fit.state.x)]
        groups, by_groups = updated_groups(
            fit.state, x, covariance, lambda group: group.effective > DECIDED
        )
        if max(by_weights, by_scales, by_groups) < SETTLED:
            break
        freedom = (
            np.einsum("nij,nji->n", fit.projected_blocks, fit.scales) / fit.weights / 3
        )
        noises = without_negligible(noises, samples.sources, samples.slopes)
        noises = with_tails(noises, samples.sources, fit.squares, freedom)
        state = replace(fit.state, groups=groups, noises=noises)
        fit = replace(fit, state=state, prior=prior, weights=weights)
    return fit


def _updated_scales(fit: CurveFit) -> tuple[float, CurvePrior, list[Noise]]:
    """Return the largest relative change, and curves and noises after a step."""
    p, noises, prior = fit.pulls, fit.state.noises, fit.prior
    learned = fit.curves if len(fit.curves) == 2 else ()
    # slopes of M by the logarithm of each square, times p, and their traces with V
    by_sample = p.reshape(-1, 3, 1)
    slopes = [(blocks @ by_sample).ravel() for blocks in fit.parts_of_noise]
    slopes += [slope @ p for slope in learned]
    traces = [np.vdot(fit.projected_blocks, blocks) for blocks in fit.parts_of_noise]
    traces += [np.vdot(fit.projection, slope) for slope in learned]
    U = np.array(slopes)
    information = 0.5 * U @ fit.projection @ U.T
    information += np.diag(1e-3 * np.diag(information) + 1e-9)
    step = np.linalg.solve(information, 0.5 * (U @ p - traces))
    step = step.clip(-LARGEST_STEP, LARGEST_STEP) / 2
    factors, changes = np.exp(step).tolist(), np.abs(step)
    if learned:
        length = prior.length * factors[-1] ** 2
        length = min(max(length, SHORTEST), LONGEST)
        changes[-1] = abs(np.log(length / prior.length))
        prior = CurvePrior(prior.amplitude * factors[-2], length)
    updated: list[Noise] = []
    for k, noise in enumerate(noises):
        s, j = factors[2 * k : 2 * k + 2]
        updated.append(replace(noise, space=noise.space * s, joint=noise.joint * j))
    return float(changes.max()), prior, updated
