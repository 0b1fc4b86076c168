"""The estimate of a robot with joint error curves, at the scales of a fit to some samples."""

from dataclasses import replace

import numpy as np

from ..identification.effects import CURVE, KNOTS
from ..identification.inference import FitPosterior, Solution, bounds_of
from ..identification.model import ExtendedModel, PriorGroup, information_of, submatrix
from .curve_fit import CurveFit
from .curve_posterior import covariance_with_curves, given_rest
from .curve_prior import CurvePrior
from .linear_samples import equations_of_rest, samples_around, solution_of_rest

ROUNDS = 8
"""Times that the samples are made linear again."""
CONVERGED = 0.1
"""Displacement of a ball, as a share of the noise, and change of a weight that end the rounds."""


def posterior_with_curves(
    posterior: FitPosterior,
    rows: np.ndarray,
    marginal: CurveFit,
    evidence: float,
) -> FitPosterior:
    """Return the result at the scales of a fit to some rows, made linear until nothing changes."""
    readings, prior, state = posterior.data, marginal.prior, marginal.state
    curves = np.zeros(marginal.samples.shape)
    weights = np.ones(len(state.errors))
    weights[rows] = marginal.next_weights
    for _ in range(ROUNDS):
        state, samples = samples_around(state, readings, curves)
        fit = CurveFit(state, samples, prior, weights)
        part = given_rest(fit)
        change = _within_bounds(fit, part.information).change
        y = np.append(change, 1.0)
        e = part.gain @ y
        c = e + fit.shift @ y
        weights = fit.weights_at(y, e)
        curves = c.reshape(curves.shape)
        state = fit.state.changed(change)
        if _settled(fit, change, weights):
            break
    state, samples = samples_around(state, readings, curves)
    nu = state.degrees
    fit = CurveFit(state, samples, prior, information_of(weights, nu))
    part = given_rest(fit)
    of_rest = _within_bounds(fit, part.information, widened=True)
    of_all = covariance_with_curves(fit, part, of_rest.covariance)
    weights = weights * nu / (nu + 3)
    marginal = replace(fit, weights=weights)
    return _posterior(posterior, marginal, curves, of_all, evidence)


def _settled(fit: CurveFit, change: np.ndarray, weights: np.ndarray) -> bool:
    """Return True where a round changed no ball and no weight by more than CONVERGED."""
    G = fit.columns[:, :, :-1]
    shift = np.abs(G @ change).max()
    least_noise = min(noise.space for noise in fit.state.noises)
    return max(shift / least_noise, np.abs(weights - fit.weights).max()) < CONVERGED


def _within_bounds(
    fit: CurveFit,
    information: np.ndarray,
    *,
    widened: bool = False,
) -> Solution:
    """Return as :func:`solution_of_rest`, by the moments of what is never negative."""
    state = fit.state
    bounds = bounds_of(state, solution_of_rest(state, fit.rest, information))
    equations = equations_of_rest(state, widened=widened) + bounds.equations
    return solution_of_rest(state, equations, information)


def _posterior(
    posterior: FitPosterior,
    marginal: CurveFit,
    curves: np.ndarray,
    of_all: np.ndarray,
    evidence: float,
) -> FitPosterior:
    """Return the result with curves, (KNOTS, m), which ``of_all`` has last, in their place."""
    objective, state = posterior.objective, marginal.state
    size, n = posterior.model.size, objective.size
    extensions = (*posterior.model.extensions, CURVE.name)
    model = posterior.model.with_effects(extensions)
    order = np.r_[:size, n : len(of_all), size:n]
    covariance = submatrix(of_all, order)
    knots = size + np.arange(curves.size).reshape(curves.shape)
    groups = [
        replace(group, members=group.members + curves.size * (group.members >= size))
        for group in state.groups
    ]
    groups.append(curve_group(model, knots, marginal.prior, covariance))
    none = np.zeros(curves.size)
    state = replace(
        state,
        objective=replace(objective, model=model),
        x=np.insert(state.x, size, curves.ravel()),
        at_zero=np.insert(state.at_zero, size, none.astype(bool)),
        groups=tuple(groups),
    )
    iterates = [np.insert(x, size, none) for x in posterior.iterates]
    return FitPosterior(
        state,
        posterior.around,
        marginal.weights,
        evidence,
        [*iterates, state.x],
        covariance,
    )


def curve_group(
    model: ExtendedModel,
    knots: np.ndarray,
    prior: CurvePrior,
    covariance: np.ndarray,
) -> PriorGroup:
    """Return the prior of curves by their places in the covariance, (KNOTS, m)."""
    P = CurvePrior(prior.amplitude, prior.length).inverse
    effective = 0.0
    for k, joint in enumerate(model.robot.actuated):
        if joint.type != "prismatic":
            share = P * submatrix(covariance, knots[:, k])
            effective += KNOTS - float(np.sum(share))
    return PriorGroup(
        CURVE.name,
        CURVE.unit,
        knots.ravel(),
        prior.amplitude,
        effective=effective,
        length=prior.length,
        optional=True,
    )
