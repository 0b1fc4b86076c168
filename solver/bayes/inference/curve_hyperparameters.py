"""Amplitude and length of the joint error curves, noise and prior widths, by the evidence."""

from dataclasses import dataclass, replace

import numpy as np

from ..model import NEGLIGIBLE, Noise, PriorGroup, degrees_of_freedom
from .curve_marginal import CurvePrior, Marginal, curve_covariance, marginal
from .laplace import expectation_propagation, log_evidence_of_scales, log_prior_share
from .linear_samples import LinearSamples, Rest, rest_of
from .objective import Objective, State, priors
from .state import updated_groups

SHORTEST, LONGEST = 0.02, 0.2
"""Bounds of the curves' length [rad]."""
STEPS = 30
SETTLED = 0.1
"""Relative change of the scales at which they are found: by a step of Newton, to some 1 %."""
LARGEST_STEP = 1.0
"""Of the logarithm of a scale's square."""
DECIDED = 0.5
"""Number of unknowns that the data decide from which on a group's width is to settle."""
MOST_HIDDEN = 0.9
"""Share of an error that a fit can hide, for all that its tails are judged by."""


@dataclass(frozen=True)
class _Iteration:
    """A fit at given scales and weights."""

    samples: LinearSamples
    state: State
    """Around which the samples are linear, with the scales."""
    prior: CurvePrior
    weights: np.ndarray
    """w_i of the fit, shape (N,)."""
    rest: Rest
    curves: tuple[np.ndarray, ...]
    """See :func:`curve_covariance`."""
    scales: np.ndarray
    """C_i, shape (N, 3, 3)."""
    found: Marginal
    squares: np.ndarray
    """e_i^T C_i^-1 e_i after the fit, shape (N,)."""

    @property
    def next_weights(self) -> np.ndarray:
        """The weights by these errors, shape (N,)."""
        nu = self.samples.degrees(self.state.noises)
        return (nu + 3) / (nu + self.squares)


def _iteration(
    objective: Objective,
    state: State,
    samples: LinearSamples,
    prior: CurvePrior,
    weights: np.ndarray,
) -> _Iteration:
    """Return the fit at a state's noises and prior widths."""
    rest = rest_of(objective, state, len(weights) / len(state.linear.errors))
    C, curves = samples.scales(state.noises), curve_covariance(samples, prior)
    blocks = C / weights[:, None, None]
    found = marginal(samples, curves, blocks, rest)
    errors = blocks @ found.pulls.reshape(-1, 3, 1)
    squares: np.ndarray = np.sum(errors * np.linalg.solve(C, errors), axis=(1, 2))
    return _Iteration(samples, state, prior, weights, rest, curves, C, found, squares)


@dataclass(frozen=True)
class Marginalised:
    """A fit whose curves are integrated out."""

    prior: CurvePrior
    state: State
    """Around which the samples are linear, with the noises and prior widths that were found."""
    weights: np.ndarray
    """Robust weights w_i, shape (N,)."""
    change: np.ndarray
    """y, shape (d,)."""
    pulls: np.ndarray
    """p_i, shape (N, 3), see :class:`Marginal`."""
    log_evidence: float
    """Of the samples, by Laplace's approximation, but for a constant."""


def marginalised(
    objective: Objective,
    state: State,
    samples: LinearSamples,
    prior: CurvePrior,
    weights: np.ndarray,
    *,
    learn: bool = True,
) -> Marginalised:
    """Return the scales of highest evidence, and the fit with them."""
    fit = _iteration(objective, state, samples, prior, weights)
    for _ in range(STEPS):
        weights = fit.next_weights
        change = 0.2 * float(np.abs(np.log(weights / fit.weights)).max())
        if learn:
            by_scales, prior, noises = _updated_scales(fit)
            x = fit.state.x + fit.found.change[: len(fit.state.x)]
            groups, by_groups = updated_groups(fit.state, x, fit.found.covariance, _is_decided)
            state = replace(fit.state, groups=groups, noises=_with_tails(fit, noises))
            change = max(change, by_scales, by_groups)
        if change < SETTLED:
            break
        fit = _iteration(objective, state, samples, prior, weights)
    pulls = fit.found.pulls.reshape(-1, 3)
    evidence = _log_evidence(fit) if learn else -np.inf
    return Marginalised(fit.prior, fit.state, weights, fit.found.change, pulls, evidence)


def _is_decided(group: PriorGroup) -> bool:
    return group.effective > DECIDED


def _updated_scales(fit: _Iteration) -> tuple[float, CurvePrior, list[Noise]]:
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
            traces.append(float(np.sum(found.blocks * block)))
    for one in fit.curves if len(fit.curves) == 2 else (None, None):
        slopes.append(0 * p if one is None else one @ p)
        traces.append(0.0 if one is None else found.trace(one))
    U = np.array(slopes)
    information = 0.5 * U @ found.projected(U.T)
    information += np.diag(1e-3 * np.diag(information) + 1e-9)
    step = np.linalg.solve(information, 0.5 * (U @ p - np.array(traces)))
    step = step.clip(-LARGEST_STEP, LARGEST_STEP) / 2
    factors, counted = np.exp(step).tolist(), np.abs(step)
    length = float(np.clip(prior.length * factors[-1] ** 2, SHORTEST, LONGEST))
    counted[-1] = abs(np.log(length / prior.length))
    prior = CurvePrior(prior.amplitude * factors[-2], length)
    updated = [
        replace(one, space=one.space * space, joint=one.joint * joint)
        for one, space, joint in zip(noises, factors[:-2:2], factors[1:-2:2], strict=True)
    ]
    return float(counted.max()), prior, updated


def _with_tails(fit: _Iteration, noises: list[Noise]) -> tuple[Noise, ...]:
    """Return the noises with tails as heavy as those of the errors, but for what the fit hides."""
    samples = fit.samples
    left = np.einsum("nij,nji->n", fit.found.blocks, fit.scales) / fit.weights / 3
    squares = fit.squares / left.clip(min=1 - MOST_HIDDEN)
    updated: list[Noise] = []
    for k, noise in enumerate(noises):
        rows = samples.sources == k
        negligible = noise.joint_effect(samples.slopes[rows]) < NEGLIGIBLE
        joint = 0.0 if negligible else noise.joint
        updated.append(replace(noise, joint=joint, nu=degrees_of_freedom(squares[rows])))
    return tuple(updated)


def _log_evidence(fit: _Iteration) -> float:
    """Return the logarithm of the evidence but for a constant, as in (A6)."""
    state, samples, C = fit.state, fit.samples, fit.scales
    nu, y, p = samples.degrees(state.noises), fit.found.change, fit.found.pulls
    told = C / (fit.weights * (nu + 3) / (nu + 5))[:, None, None]
    sharp = marginal(samples, fit.curves, told, fit.rest)
    terms = [
        -0.5 * sharp.log_determinants,
        0.5 * float(np.sum(np.linalg.slogdet(told)[1] - np.linalg.slogdet(C)[1])),
        -0.5 * float(np.sum((nu + 3) * np.log1p(fit.squares / nu))),
        -0.5 * float(y @ fit.rest.precision @ y) - float(fit.rest.gradient @ y),
        -0.5 * sum(float(p @ K @ p) for K in fit.curves[:1]),
    ]
    for group, free in priors(state):
        off = (state.x[group.members] - group.mean)[free]
        terms.append(-0.5 * float(off @ group.precision(group.width, free) @ off))
    limited = [g.members for g in state.groups if g.non_negative and g.width]
    if limited:
        b = np.concatenate(limited)
        b = b[fit.rest.free[b]]
        known = sharp.covariance[np.ix_(b, b)]
        *_, share = expectation_propagation(state.x[b] + y[b], known)
        terms.append(share - log_prior_share(state))
    return sum(terms) + log_evidence_of_scales(state, np.bincount(samples.sources).tolist())
