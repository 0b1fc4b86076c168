"""Amplitude and length of the joint error curves, noise and prior widths, by the evidence."""

from dataclasses import replace

import numpy as np

from ..model import Noise, PriorGroup
from .curve_marginal import CurveFit
from .curve_prior import CurvePrior
from .laplace import expectation_propagation, log_evidence_of_scales, log_prior_share
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


def log_evidence(fit: CurveFit) -> float:
    """Return the logarithm of the evidence of a fit but for a constant, as in (A6)."""
    state, nu, p, rest = fit.state, fit.degrees, fit.pulls, fit.rest
    y, _ = fit.posterior
    told = fit.weights * (nu + 3) / (nu + 5)
    sharp = replace(fit, weights=told)
    terms = [
        -0.5 * sharp.log_determinants,
        -1.5 * float(np.sum(np.log(told))),
        -0.5 * float(np.sum((nu + 3) * np.log1p(fit.squares / nu))),
        -0.5 * float(y @ rest.precision @ y) - float(rest.gradient @ y),
        -0.5 * sum(float(p @ K @ p) for K in fit.curves[:1]),
    ]
    for group, free in state.priors:
        off = (state.x[group.members] - group.mean)[free]
        terms.append(-0.5 * float(off @ group.precision(group.width, free) @ off))
    b = np.flatnonzero(state.bounded & rest.free)
    if len(b):
        known = sharp.posterior[1][np.ix_(b, b)]
        terms.append(expectation_propagation(state.x[b] + y[b], known)[2])
    terms.append(-log_prior_share(state))
    return sum(terms) + log_evidence_of_scales(state, np.bincount(fit.samples.sources).tolist())


def marginalised(fit: CurveFit) -> CurveFit:
    """Return the fit at the scales of highest evidence."""
    samples = fit.samples
    for _ in range(STEPS):
        weights = fit.next_weights
        by_weights = 0.2 * float(np.abs(np.log(weights / fit.weights)).max())
        by_scales, prior, noises = _updated_scales(fit)
        y, covariance = fit.posterior
        x = fit.state.x + y[: len(fit.state.x)]
        groups, by_groups = updated_groups(fit.state, x, covariance, _is_decided)
        if max(by_weights, by_scales, by_groups) < SETTLED:
            break
        left = np.einsum("nij,nji->n", fit.projected_blocks, fit.scales) / fit.weights / 3
        noises = without_negligible(noises, samples.sources, samples.slopes)
        noises = with_tails(noises, samples.sources, fit.squares, left)
        state = replace(fit.state, groups=groups, noises=noises)
        fit = replace(fit, state=state, prior=prior, weights=weights)
    return fit


def _is_decided(group: PriorGroup) -> bool:
    return group.effective > DECIDED


def _updated_scales(fit: CurveFit) -> tuple[float, CurvePrior, list[Noise]]:
    """Return the largest relative change, and curves and noises after a step."""
    samples, p, noises, prior = fit.samples, fit.pulls, fit.state.noises, fit.prior
    by_joints = samples.slopes @ samples.slopes.transpose(0, 2, 1)
    slopes: list[np.ndarray] = []  # of M by the logarithm of each square, times p
    traces: list[float] = []
    for k, noise in enumerate(noises):
        for square, V_i in ((noise.space**2, np.eye(3)), (noise.joint**2, by_joints)):
            block = square * V_i * ((samples.sources == k) / fit.weights)[:, None, None]
            slopes.append((block @ p.reshape(-1, 3, 1)).ravel())
            traces.append(float(np.sum(fit.projected_blocks * block)))
    learned = fit.curves if len(fit.curves) == 2 else ()
    slopes += [one @ p for one in learned]
    traces += [fit.trace(one) for one in learned]
    U = np.array(slopes)
    information = 0.5 * U @ fit.projected(U.T)
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
