"""Laplace's approximation: posterior, as a Gaussian around the best unknowns, and evidence."""

from dataclasses import replace
from math import erfc, exp, log, pi, sqrt

import numpy as np

from ..model import (
    TYPICAL_SPREAD,
    Gaussian,
    Movement,
    Noise,
    fitted_squares,
    log_constant,
    log_determinant,
    log_prior,
    student_weights,
    submatrix,
)
from .normal_equations import curvature, inverse_of_free, normal_equations
from .objective import linearise
from .posterior import FitPosterior
from .state import State
from .steps import moved
from .width_averaging import at_usual_widths, over_widths

SWEEPS = 200
DAMPING = 0.5
SETTLED = 1e-6
TAIL_STEPS = 12
"""Until errors are as large as their noise says."""


def expectation_propagation(
    mean: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return precision and pull of a factor for each bound x >= 0 (Minka 2001), and log share."""
    unit = np.sqrt(np.diag(covariance))  # unknowns in units of their own deviation
    S, m = covariance / np.outer(unit, unit), mean / unit
    P = np.linalg.inv(S)
    h = P @ m
    tau, nu = np.zeros(len(m)), np.zeros(len(m))
    precision, pull, log_half = tau, nu, tau
    for _ in range(SWEEPS):
        now = np.linalg.inv(P + np.diag(tau))
        centre, variance = now @ (h + nu), np.diag(now)
        # The others are without its own factor.
        precision, pull = (
            1 / variance - tau,
            centre / variance - nu,
        )
        z = pull / np.sqrt(precision)
        hazard, excess, log_half = np.array([_half(value) for value in z.tolist()]).T
        target = precision / (1 - hazard * excess)  # 1 / variance with the bound
        changes = (
            target - precision - tau,
            target * excess / np.sqrt(precision) - pull - nu,
        )
        tau, nu = tau + DAMPING * changes[0], nu + DAMPING * changes[1]
        if np.abs(changes).max() < SETTLED * (1 + np.abs([tau, nu]).max()):
            break
    now = np.linalg.inv(P + np.diag(tau))
    squares = (pull + nu) ** 2 / (precision + tau) - pull**2 / precision
    terms = [
        0.5 * ((h + nu) @ now @ (h + nu) - m @ h),
        -0.5 * np.linalg.slogdet(np.eye(len(m)) + S * tau)[1],
        np.sum(log_half + 0.5 * np.log1p(tau / precision) - 0.5 * squares),
    ]
    return tau / unit**2, nu / unit, float(sum(terms))


def factors_of_bounds(
    state: State, change: np.ndarray, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return precision and slope at x of the factors of all bounds, shape (n,), and log share.

    Without bounds, the unknowns are x and a change, with a covariance.
    """
    b = np.flatnonzero(state.bounded & state.free)
    precision, slope = np.zeros((2, len(change)))
    if not len(b):
        return precision, slope, 0.0
    x = state.x[b]
    sigma = submatrix(covariance, b)
    precision[b], pull, log_share = expectation_propagation(x + change[b], sigma)
    slope[b] = precision[b] * x - pull
    return precision, slope, log_share


def _half(z: float) -> tuple[float, float, float]:
    """Return hazard, mean and log share of the half x >= 0 of a standard Gaussian around z."""
    log_density = -0.5 * z**2 - 0.5 * log(2 * pi)
    if z > -5:
        share = 0.5 * erfc(-z / sqrt(2))
        hazard = exp(log_density) / share
        return hazard, z + hazard, log(share)
    fraction = -z  # Laplace's continued fraction, where rounding would leave nothing
    for k in range(40, 1, -1):
        fraction = -z + k / fraction
    mean = 1 / fraction
    return mean - z, mean, log_density - log(mean - z)


def posterior(state: State, iterates: list[np.ndarray]) -> FitPosterior:
    """Return the Gaussian posterior at a state where the iteration has settled."""
    # all that may leave zero does
    state = replace(state, at_zero=state.at_zero & ~state.bounded[: len(state.x)])
    information, gradient = normal_equations(state)
    prior, free = state.prior_precision(), state.free
    gradient = gradient + state.linear.by_volume
    slope = gradient + prior @ state.offset
    hessian = information + prior
    covariance = inverse_of_free(hessian, free)
    change = -covariance @ slope
    evidence = (
        log_evidence_of_scales(state, state.objective.data.source_of) - state.value()
    )
    evidence -= 0.5 * float(slope @ change) + 0.5 * log_determinant(
        submatrix(hessian, free)
    )
    bounds, slope_of_bounds, log_share = factors_of_bounds(state, change, covariance)
    evidence += log_share
    mean = state
    if bounds.any():
        covariance = inverse_of_free(hessian + np.diag(bounds), free)
        change = -covariance @ (slope + slope_of_bounds)
        mean = moved(state, change)
        iterates = [*iterates, mean.x]
    # The data's slope and the usual widths tell the rest: found ones may have fallen to nothing.
    usual = at_usual_widths(state)
    precision = _of_data(state) + usual.prior_precision(widened=True) + np.diag(bounds)
    slope = gradient + usual.prior_precision() @ usual.offset
    of_free = Gaussian.of_precision(change[free], submatrix(precision, free))
    spread = of_free.embedded(free, len(free))
    difference = -spread.covariance @ (slope + slope_of_bounds) - change
    at_usual = replace(spread, mean=difference)
    mixture, groups = over_widths(state, state.padded + change, at_usual)
    weights = mean.weights * mean.degrees / (mean.degrees + 3)
    return FitPosterior(
        replace(mean, groups=groups), mixture, weights, evidence, iterates
    )


def _of_data(state: State) -> np.ndarray:
    """Return the data's curvature, less what it claims to know too much, by the errors' tails."""
    # Errors that are more Gaussian than Student's with their nu leave the best fit less sure than
    # the curvature says, since the robust weights pass over some of what they tell.
    weights = state.information
    for source, noise in zip(state.objective.data.sources, state.noises, strict=True):
        weights[source] *= _efficiency(state.squares[source], noise)
    return curvature(state, state.inverse_scales * weights[:, None, None])


def _efficiency(squares: np.ndarray, noise: Noise) -> float:
    """Return how much errors tell, relative to what the curvature says."""
    if not squares.any():
        return 1.0
    squares, _ = fitted_squares(squares, noise.nu, TAIL_STEPS)
    weights = student_weights(squares, noise.nu)
    influences = weights**2 * squares
    slope = np.mean(weights - 2 / 3 * influences / (noise.nu + 3))
    return float(slope**2 / (np.mean(influences) / 3 * noise.information))


def _log_prior_share(state: State) -> float:
    """Return log A: a half is within the bound for each unknown whose mean is zero."""
    result = 0.0
    for group in state.groups:
        if group.non_negative and group.width:
            ratios = group.mean / np.sqrt(np.diag(group.covariance(group.width)))
            result += sum(_half(ratio)[2] for ratio in ratios.tolist())
    return result


def log_evidence_of_scales(state: State, sources: np.ndarray) -> float:
    """Return the part of (A6) by widths and noises alone, for the noise of each sample, (N,)."""
    result = -_log_prior_share(state)
    for count, noise in zip(np.bincount(sources).tolist(), state.noises, strict=True):
        result += count * log_constant(noise.nu) + log_prior(noise.nu)
    for group, mask in state.priors:
        precision = group.precision(group.width, mask)
        result += 0.5 * float(np.linalg.slogdet(precision)[1])
        if group.typical:
            result -= 0.5 * (log(group.width / group.typical) / TYPICAL_SPREAD) ** 2
    return result


def movement_gain(result: FitPosterior, movement: Movement) -> float:
    """Return the rise of the logarithm of the evidence by a further movement, to first order.

    With g the slope of L by its unknowns u, P their prior's precision and S their covariance beside
    all other unknowns, it is (g^T S g + log |S| + log |P|) / 2.
    """
    before = result.state
    prior = movement.prior(len(before.x))
    movements = (*result.objective.movements, movement)
    objective = replace(result.objective, movements=movements)
    x = np.pad(before.x, (0, movement.size))
    at_zero = np.pad(before.at_zero, (0, movement.size))
    linear = linearise(objective, x, before.frames)
    groups = (*before.groups, prior)
    state = replace(before, objective=objective, x=x, at_zero=at_zero)
    state = replace(state, groups=groups, linear=linear)
    information, gradient = normal_equations(state)
    covariance = inverse_of_free(information + state.prior_precision(), state.free)
    new = slice(len(before.x), len(x))
    S, g = covariance[new, new], gradient[new]
    logs = log_determinant(S) + log_determinant(prior.precision(prior.width))
    return 0.5 * (float(g @ S @ g) + logs)
