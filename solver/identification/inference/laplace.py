"""Laplace's approximation: posterior, as a Gaussian around the best unknowns, and evidence."""

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from ..model import (
    TYPICAL_SPREAD,
    Gaussian,
    Noise,
    fitted_squares,
    log_constant,
    log_prior,
    student_weights,
)
from .arrow import Arrow
from .bounds import Bounds, bounds_of, half_moments
from .normal_equations import (
    NormalEquations,
    curvature,
    data_equations,
    prior_equations,
)
from .posterior import FitPosterior
from .state import State
from .steps import moved
from .width_averaging import around_estimate, at_usual_widths

TAIL_STEPS = 12
"""Until errors are as large as their noise says."""


def posterior(state: State, iterates: Sequence[np.ndarray]) -> FitPosterior:
    """Return the Gaussian posterior at a state where the iteration has settled (A6).

    With the slope g and the curvature H of L there, d = -H^-1 g, and the evidence is

        log Z = -L - g^T d / 2 - log |H| / 2 + log (share within bounds) + terms of the scales
    """
    # all that may leave zero does
    bounded = state.bounded[: len(state.x)]
    state = replace(state, at_zero=state.at_zero & ~bounded)
    data = data_equations(state).tilted(state.linear.volume.slope)
    equations = data + prior_equations(state)
    solution = equations.solution(state.free)
    bounds = bounds_of(state, solution)
    evidence = log_evidence_of_scales(state, state.objective.data.source_of)
    evidence -= state.value()
    evidence -= 0.5 * float(equations.g @ solution.change)
    evidence -= 0.5 * equations.arrow(state.free).log_determinant
    evidence += bounds.log_share
    change, mean = solution.change, state
    if bounds.any:
        bounded_equations = equations + bounds.equations
        change = bounded_equations.solution(state.free).change
        mean = moved(state, change)
        iterates = [*iterates, mean.x]
    at_usual = _at_usual_widths(state, data, bounds, change)
    around = around_estimate(at_usual)
    at_usual = replace(
        at_usual, root=around.root[:, :-1]
    )  # which is large, and here once
    weights = mean.weights * mean.degrees / (mean.degrees + 3)
    return FitPosterior(
        state=mean.without_slopes,
        around=around,
        weights=weights,
        log_evidence=evidence,
        iterates=iterates,
        at_usual_widths=(state.padded + change, at_usual),
    )


def _at_usual_widths(
    state: State,
    data: NormalEquations,
    bounds: Bounds,
    change: np.ndarray,
) -> Gaussian:
    """Return the posterior at usual widths, as changes from the estimate, a change of the state.

    The data's slope and the usual widths tell it: found ones may have fallen to nothing.
    """
    usual = at_usual_widths(state)
    prior = usual.prior_precision(widened=True)
    H = _curvature_by_tails(state) + prior + bounds.equations.H
    g = data.g + bounds.equations.g + prior_equations(usual).g
    spread = Arrow(H, state.free, state.form).gaussian(change)
    mean = -spread.covariance @ g
    return replace(spread, mean=mean - change)


def _curvature_by_tails(state: State) -> np.ndarray:
    """Return the data's curvature, less what it claims to know too much, by the errors' tails.

    Errors that are more Gaussian than Student's with their nu leave the best fit less sure than the
    curvature says, since the robust weights pass over some of what they tell.
    """
    information = state.information
    sources = state.objective.data.sources
    for rows, noise in zip(sources, state.noises, strict=True):
        information[rows] *= _efficiency(state.squares[rows], noise)
    V = information[:, None, None] * state.inverse_scales
    return curvature(state, V)


def _efficiency(squares: np.ndarray, noise: Noise) -> float:
    """Return how much errors tell, relative to what the curvature says.

    With psi = w e, whose slope is w - 2 w^2 e^2 / 3 (nu + 3) on average over directions, it is
    <slope>^2 / (<psi^2> / 3 k), the inverse of Huber's sandwich.
    """
    if not squares.any():
        return 1.0
    squares, _ = fitted_squares(squares, noise.nu, TAIL_STEPS)
    weights = student_weights(squares, noise.nu)
    influences = weights**2 * squares
    slopes = weights - 2 / 3 * influences / (noise.nu + 3)
    slope = np.mean(slopes)
    variance = np.mean(influences) / 3
    return float(slope**2 / (variance * noise.information))


def _log_prior_share(state: State) -> float:
    """Return log A: a half is within the bound for each unknown whose mean is zero."""
    log_share = 0.0
    for group in state.groups:
        if group.non_negative and group.width:
            variances = np.diag(group.covariance(group.width))
            ratios = group.mean / np.sqrt(variances)
            log_share += float(np.sum(half_moments(ratios)[2]))
    return log_share


def log_evidence_of_scales(state: State, sources: np.ndarray) -> float:
    """Return the part of (A6) by widths and noises alone, for the noise of each sample, (N,)."""
    log_evidence = -_log_prior_share(state)
    counts: list[int] = np.bincount(sources).tolist()
    for count, noise in zip(counts, state.noises, strict=True):
        log_evidence += count * log_constant(noise.nu)
        log_evidence += log_prior(noise.nu)
    for prior in state.priors:
        group = prior.group
        P = prior.precision(group.width)
        log_evidence += 0.5 * float(np.linalg.slogdet(P)[1])
        if group.typical:
            spreads = log(group.width / group.typical) / TYPICAL_SPREAD
            log_evidence -= 0.5 * spreads**2
    return log_evidence
