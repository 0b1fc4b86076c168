"""Amplitude and length of the joint error curves, noise and prior widths, by the evidence."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import Noise, PriorGroup, sample_degrees, sample_scales
from .curve_marginal import Marginal, curve_covariance
from .curve_prior import CurvePrior
from .laplace import expectation_propagation, log_evidence_of_scales, log_prior_share
from .linear_samples import LinearSamples, Rest, rest_of
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


@dataclass(frozen=True)
class CurveFit:
    """A fit to some samples at given scales and weights, its curves integrated out."""

    state: State
    """Around which the samples are linear, with the scales."""
    samples: LinearSamples
    prior: CurvePrior
    weights: np.ndarray
    """w_i of the fit, shape (N,)."""

    @cached_property
    def rest(self) -> Rest:
        """What is known besides the samples."""
        share = len(self.weights) / len(self.state.linear.errors)
        return rest_of(self.state, share)

    @cached_property
    def curves(self) -> tuple[np.ndarray, ...]:
        """See :func:`curve_covariance`."""
        return curve_covariance(self.samples, self.prior)

    @cached_property
    def scales(self) -> np.ndarray:
        """C_i, shape (N, 3, 3)."""
        return sample_scales(self.state.noises, self.samples.sources, self.samples.slopes)

    def marginal(self, weights: np.ndarray) -> Marginal:
        """Return M and what follows for some weights, shape (N,)."""
        K = self.curves[0] if self.curves else None
        return Marginal(self.samples, self.scales / weights[:, None, None], K, self.rest)

    @cached_property
    def found(self) -> Marginal:
        """By its own weights."""
        return self.marginal(self.weights)

    @cached_property
    def squares(self) -> np.ndarray:
        """e_i^T C_i^-1 e_i after the fit, shape (N,)."""
        errors = self.found.blocks @ self.found.pulls.reshape(-1, 3, 1)
        return np.sum(errors * np.linalg.solve(self.scales, errors), axis=(1, 2))

    @cached_property
    def next_weights(self) -> np.ndarray:
        """The robust weights by these errors, shape (N,)."""
        nu = sample_degrees(self.state.noises, self.samples.sources)
        return (nu + 3) / (nu + self.squares)

    @cached_property
    def log_evidence(self) -> float:
        """Logarithm of the evidence but for a constant, as in (A6)."""
        state, samples = self.state, self.samples
        nu, p = sample_degrees(state.noises, samples.sources), self.found.pulls
        y, _ = self.found.posterior
        told = self.weights * (nu + 3) / (nu + 5)
        sharp = self.marginal(told)
        terms = [
            -0.5 * sharp.log_determinants,
            -1.5 * float(np.sum(np.log(told))),
            -0.5 * float(np.sum((nu + 3) * np.log1p(self.squares / nu))),
            -0.5 * float(y @ self.rest.precision @ y) - float(self.rest.gradient @ y),
            -0.5 * sum(float(p @ K @ p) for K in self.curves[:1]),
        ]
        for group, free in state.priors:
            off = (state.x[group.members] - group.mean)[free]
            terms.append(-0.5 * float(off @ group.precision(group.width, free) @ off))
        limited = [g.members for g in state.groups if g.non_negative and g.width]
        if limited:
            b = np.concatenate(limited)
            b = b[self.rest.free[b]]
            known = sharp.posterior[1][np.ix_(b, b)]
            *_, share = expectation_propagation(state.x[b] + y[b], known)
            terms.append(share - log_prior_share(state))
        return sum(terms) + log_evidence_of_scales(state, np.bincount(samples.sources).tolist())


def marginalised(fit: CurveFit) -> CurveFit:
    """Return the fit at the scales of highest evidence."""
    for _ in range(STEPS):
        weights = fit.next_weights
        by_weights = 0.2 * float(np.abs(np.log(weights / fit.weights)).max())
        by_scales, prior, noises = _updated_scales(fit)
        y, covariance = fit.found.posterior
        x = fit.state.x + y[: len(fit.state.x)]
        groups, by_groups = updated_groups(fit.state, x, covariance, _is_decided)
        if max(by_weights, by_scales, by_groups) < SETTLED:
            break
        samples = fit.samples
        left = np.einsum("nij,nji->n", fit.found.projected_blocks, fit.scales) / fit.weights / 3
        noises = without_negligible(noises, samples.sources, samples.slopes)
        noises = with_tails(noises, samples.sources, fit.squares, left)
        state = replace(fit.state, groups=groups, noises=noises)
        fit = replace(fit, state=state, prior=prior, weights=weights)
    return fit


def _is_decided(group: PriorGroup) -> bool:
    return group.effective > DECIDED


def _updated_scales(fit: CurveFit) -> tuple[float, CurvePrior, list[Noise]]:
    """Return the largest relative change, and curves and noises after a step."""
    samples, found, p = fit.samples, fit.found, fit.found.pulls
    noises, prior = fit.state.noises, fit.prior
    by_joints = samples.slopes @ samples.slopes.transpose(0, 2, 1)
    slopes: list[np.ndarray] = []  # of M by the logarithm of each square, times p
    traces: list[float] = []
    for k, noise in enumerate(noises):
        for square, V_i in ((noise.space**2, np.eye(3)), (noise.joint**2, by_joints)):
            block = square * V_i * ((samples.sources == k) / fit.weights)[:, None, None]
            slopes.append((block @ p.reshape(-1, 3, 1)).ravel())
            traces.append(float(np.sum(found.projected_blocks * block)))
    learned = fit.curves if len(fit.curves) == 2 else ()
    slopes += [one @ p for one in learned]
    traces += [found.trace(one) for one in learned]
    U = np.array(slopes)
    information = 0.5 * U @ found.projected(U.T)
    information += np.diag(1e-3 * np.diag(information) + 1e-9)
    step = np.linalg.solve(information, 0.5 * (U @ p - np.array(traces)))
    step = step.clip(-LARGEST_STEP, LARGEST_STEP) / 2
    factors, counted = np.exp(step).tolist(), np.abs(step)
    if learned:
        length = float(np.clip(prior.length * factors[-1] ** 2, SHORTEST, LONGEST))
        counted[-1] = abs(np.log(length / prior.length))
        prior = CurvePrior(prior.amplitude * factors[-2], length)
    own = zip(noises, factors[::2], factors[1::2], strict=False)
    updated = [replace(one, space=one.space * s, joint=one.joint * j) for one, s, j in own]
    return float(counted.max()), prior, updated
