"""Amplitude and length of the joint error curves, noise and prior widths, by the evidence."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import (
    NEGLIGIBLE,
    Noise,
    PriorGroup,
    degrees_of_freedom,
)
from ..model.effects import kernel
from .hyperparameters import updated_groups
from .laplace import log_evidence_of_scales
from .linear_samples import LinearSamples, Rest, rest_of
from .objective import Objective, State, priors

SHORTEST, LONGEST = 0.02, 0.2
"""Bounds of the curves' length [rad]."""
STEPS = 30
SETTLED = 0.02
"""Relative change of the scales at which they are found."""
LARGEST_STEP = 1.0
"""Of the logarithm of a scale's square."""
DECIDED = 0.5
"""Number of unknowns that the data decide from which on a group's width is to settle."""
MOST_HIDDEN = 0.9
"""Share of an error that a fit can hide, for all that its tails are judged by."""


@dataclass(frozen=True)
class CurvePrior:
    """The Gaussian process of all curves."""

    amplitude: float
    """s [rad]; 0 for no curves."""
    length: float
    """l [rad]."""


@dataclass(frozen=True)
class Marginal:
    """The errors' covariance, and what follows of the unknowns beside the curves."""

    errors: np.ndarray
    """M, shape (3 N, 3 N)."""
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

    inverse: np.ndarray | None
    """M^-1, shape (3 N, 3 N), where it was asked for."""

    @cached_property
    def projected(self) -> np.ndarray:
        """V = M^-1 - M^-1 G Sigma G^T M^-1, shape (3 N, 3 N)."""
        sigma = self.covariance[np.ix_(self.free, self.free)]
        inverse = np.linalg.inv(self.errors) if self.inverse is None else self.inverse
        return inverse - (self.by_rest @ sigma) @ self.by_rest.T

    @property
    def log_determinants(self) -> float:
        """Log |M| - log |Sigma|."""
        unit = np.sqrt(np.diag(self.covariance)[self.free])
        sigma = self.covariance[np.ix_(self.free, self.free)] / unit[:, None] / unit
        logs = np.linalg.slogdet(self.errors)[1] - np.linalg.slogdet(sigma)[1]
        return float(logs - 2 * np.log(unit).sum())


def curve_covariance(samples: LinearSamples, prior: CurvePrior) -> tuple[np.ndarray, np.ndarray]:
    """Return the curves' part of M, and its derivative by log l, each of shape (3 N, 3 N)."""
    n = 3 * len(samples.errors)
    if samples.given is not None:
        return samples.given_covariance, np.zeros((n, n))
    K, by_length = np.zeros((2, n, n))
    if not prior.amplitude:
        return K, by_length
    same = samples.arms[:, None] == samples.arms if samples.count > 1 else 1.0
    for distance, outer in zip(samples.distances, samples.outer_slopes, strict=True):
        for total, part in zip((K, by_length), kernel(distance, prior.length), strict=True):
            scaled = prior.amplitude**2 * part * same
            total.reshape(outer.shape)[:] += outer * scaled[:, None, :, None]
    return K, by_length


def marginal(
    samples: LinearSamples,
    K: np.ndarray,
    blocks: np.ndarray,
    rest: Rest,
    *,
    inverted: bool = False,
) -> Marginal:
    """Return what follows of M for some blocks C_i / w_i, shape (N, 3, 3)."""
    n, d, free = len(blocks), len(rest.free), rest.free
    M = K.copy()
    M.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)] += blocks
    G, a = samples.by_rest.reshape(-1, d)[:, free], samples.errors.ravel()
    both = np.concatenate([G, a[:, None]], axis=1)
    inverse = np.linalg.inv(M) if inverted else None
    solved = np.linalg.solve(M, both) if inverse is None else inverse @ both
    WG = solved[:, :-1]
    information = G.T @ WG + rest.precision[np.ix_(free, free)]
    unit = 1 / np.sqrt(np.diag(information))
    H = information * unit[:, None] * unit
    sigma = np.linalg.inv(H) * unit[:, None] * unit
    change, covariance = np.zeros(d), np.zeros((d, d))
    change[free] = -sigma @ (WG.T @ a + rest.gradient[free])
    covariance[np.ix_(free, free)] = sigma
    return Marginal(M, WG, covariance, change, solved[:, -1] + WG @ change[free], free, inverse)


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
    curves: tuple[np.ndarray, np.ndarray]
    """The curves' part of M, and its derivative by log l."""
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
    learn: bool,
) -> _Iteration:
    """Return the fit at a state's noises and prior widths."""
    rest = rest_of(objective, state, len(weights) / len(state.linear.errors))
    C, curves = samples.scales(state.noises), curve_covariance(samples, prior)
    blocks = C / weights[:, None, None]
    found = marginal(samples, curves[0], blocks, rest, inverted=learn)
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
    fit = _iteration(objective, state, samples, prior, weights, learn)
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
        fit = _iteration(objective, state, samples, prior, weights, learn)
    pulls = fit.found.pulls.reshape(-1, 3)
    evidence = _log_evidence(fit) if learn else -np.inf
    return Marginalised(fit.prior, fit.state, weights, fit.found.change, pulls, evidence)


def _is_decided(group: PriorGroup) -> bool:
    return group.effective > DECIDED


def _updated_scales(fit: _Iteration) -> tuple[float, CurvePrior, list[Noise]]:
    """Return the largest relative change, and curves and noises after a step."""
    samples, V, p = fit.samples, fit.found.projected, fit.found.pulls
    n, noises, prior = len(fit.weights), fit.state.noises, fit.prior
    own = V.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)]
    by_joints = samples.slopes @ samples.slopes.transpose(0, 2, 1)
    slopes: list[np.ndarray] = []  # of M by the logarithm of each square, times p
    traces: list[float] = []
    for k, noise in enumerate(noises):
        for square, V_i in ((noise.space**2, np.eye(3)), (noise.joint**2, by_joints)):
            block = square * V_i * ((samples.sources == k) / fit.weights)[:, None, None]
            slopes.append((block @ p.reshape(-1, 3, 1)).ravel())
            traces.append(float(np.sum(own * block)))
    for one in fit.curves if samples.given is None else (0 * V, 0 * V):
        slopes.append(one @ p)
        traces.append(float(np.sum(V * one)))
    U = np.array(slopes)
    information = 0.5 * U @ V @ U.T
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
    samples, n = fit.samples, len(fit.weights)
    own = fit.found.projected.reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)]
    left = np.einsum("nij,nji->n", own, fit.scales) / fit.weights / 3
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
    sharp = marginal(samples, fit.curves[0], told, fit.rest)
    terms = [
        -0.5 * sharp.log_determinants,
        0.5 * float(np.sum(np.linalg.slogdet(told)[1] - np.linalg.slogdet(C)[1])),
        -0.5 * float(np.sum((nu + 3) * np.log1p(fit.squares / nu))),
        -0.5 * float(y @ fit.rest.precision @ y) - float(fit.rest.gradient @ y),
        -0.5 * float(p @ fit.curves[0] @ p),
    ]
    for group, free in priors(state):
        off = (state.x[group.members] - group.mean)[free]
        terms.append(-0.5 * float(off @ group.precision(group.width, free) @ off))
    return sum(terms) + log_evidence_of_scales(state, np.bincount(samples.sources).tolist())
