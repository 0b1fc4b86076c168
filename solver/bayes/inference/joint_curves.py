"""The fit of each joint's error curve together with everything else."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..model import SMALLEST, ExtendedModel, PriorGroup, joint_reach, submatrix
from ..model.effects import CURVE, KNOTS
from .curve_marginal import LONGEST, CurveFit, log_evidence, marginalised
from .curve_posterior import MOST_SAMPLES, given_rest, with_curves
from .curve_prior import CurvePrior, given_curves
from .curve_score import promised_gain
from .laplace import factors_of_bounds
from .linear_samples import posterior_of_rest, priors_of_rest, samples_around
from .posterior import FitPosterior

LOG_EVIDENCE = 10.0
"""Least rise of the logarithm of the evidence by which curves are kept. On arms without curves,
sockets or points, it rose by 2.4 at most in 60 recordings."""
GIVEN = "kept, as an earlier calibration has them and these data change them"
FIRST_SAMPLES, HINT = 100, 1.0
"""Samples that are looked at first, and the rise below which curves are not sought on."""
EXACT = 10.0
"""Noise of less than so many times the least that there may be is that of exact data."""
FIRST_LENGTH = 0.08
"""Length at which the search begins [rad]."""
ROUNDS = 8
"""Times that the samples are made linear again."""
CONVERGED = 0.1
"""Displacement of a ball, as a share of the noise, and change of a weight that end the rounds."""


def _may_have_curves(posterior: FitPosterior) -> bool:
    """Return True where curves are identifiable: by points or two placements, without play."""
    measured = bool((posterior.data.sockets < 0).any())
    plays = any(group.width for group in posterior.arm.groups if group.follows_noise)
    exact = min(noise.space for noise in posterior.state.noises) <= EXACT * SMALLEST
    return not exact and not plays and (measured or len(posterior.data.placements) > 1)


def with_joint_curves(
    posterior: FitPosterior,
    alternative: tuple[FitPosterior, float] | None,
    progress: Callable[[str], None],
) -> tuple[FitPosterior, str]:
    """Return a result with error curves of its joints where the data support them, and why.

    In sockets it takes two placements: at one, geometry explains as much. Joints with play hide
    curves. Where none can be found there are no words. ``alternative`` is the result of another
    model that may be more probable beside curves, and the logarithm of its odds before the data.
    """
    prior = given_curves(posterior.model)
    if prior is None and not _may_have_curves(posterior):
        return posterior, ""
    progress(CURVE.extension)
    try:
        return _with_joint_curves(posterior, alternative, prior)
    except np.linalg.LinAlgError:  # of exact data, say, which leave no noise
        return (
            posterior,
            "not supported by the data (with them, the fit does not settle)",
        )


def _with_joint_curves(
    posterior: FitPosterior,
    alternative: tuple[FitPosterior, float] | None,
    prior: CurvePrior | None,
) -> tuple[FitPosterior, str]:
    state, samples = samples_around(posterior.state, posterior.data)
    n = len(samples.sources)
    if prior is not None:
        rows = _random_rows(n, MOST_SAMPLES)
        marginal = marginalised(
            CurveFit(state, samples.of(rows), prior, np.ones(len(rows)))
        )
        return _converged(posterior, rows, marginal, posterior.log_evidence), GIVEN
    marginal = None
    for count in (FIRST_SAMPLES, MOST_SAMPLES):
        rows = _random_rows(n, count)
        flat = CurveFit(
            state, samples.of(rows), CurvePrior(0.0, LONGEST), np.ones(len(rows))
        )
        flat = marginalised(flat)
        if promised_gain(flat) < HINT:
            return (
                posterior,
                "not supported by the data (they would not raise the evidence)",
            )
        state, first = flat.state, marginal or _initial_scales(flat)
        begun = replace(
            flat, state=first.state, prior=first.prior, weights=flat.next_weights
        )
        marginal = marginalised(begun)
        before, after = log_evidence(flat), log_evidence(marginal)
        gain = after - before
        if gain <= HINT or len(rows) == n:
            break
    evidence = f"(log evidence {gain:+.1f})"
    if not gain > LOG_EVIDENCE:
        return posterior, f"not supported by the data {evidence}"
    start, evidence_of_start = posterior, posterior.log_evidence - before
    if alternative is not None:
        other, log_odds = alternative
        state, samples = samples_around(other.state, posterior.data)
        state = replace(state, noises=marginal.state.noises)
        weights = marginal.next_weights
        fit = marginalised(CurveFit(state, samples.of(rows), marginal.prior, weights))
        evidence_of_other = log_evidence(fit)
        if evidence_of_other + log_odds > after:
            start, marginal, after = other, fit, evidence_of_other
    return _converged(
        start, rows, marginal, evidence_of_start + after
    ), f"kept {evidence}"


def _random_rows(count: int, size: int) -> np.ndarray:
    """Return the samples of which the evidence is worked out."""
    ranks: np.ndarray = np.random.default_rng(0).random(count).argsort().argsort()
    return np.flatnonzero(ranks < size)


def _initial_scales(flat: CurveFit) -> CurveFit:
    """Return scales by which curves explain half of the errors, and noise the rest."""
    samples = flat.samples
    squares: np.ndarray = np.sum(samples.columns[:, :, -1] ** 2, axis=1)
    square = float(np.median(squares)) / 2.37  # the median of chi^2_3
    half = 0.5**0.5
    noises = tuple(
        replace(noise, space=half * noise.space, joint=half * noise.joint)
        for noise in flat.state.noises
    )
    prior = CurvePrior(half * square**0.5 / joint_reach(samples.slopes), FIRST_LENGTH)
    return replace(flat, state=replace(flat.state, noises=noises), prior=prior)


def _converged(
    posterior: FitPosterior, rows: np.ndarray, marginal: CurveFit, evidence: float
) -> FitPosterior:
    """Return the result at the scales of a fit to some rows, made linear until nothing changes."""
    readings, prior, state = posterior.data, marginal.prior, marginal.state
    weights, coefficients = np.ones(len(state.errors)), np.zeros(marginal.samples.shape)
    weights[rows] = marginal.next_weights
    for _ in range(ROUNDS):
        fit = CurveFit(*samples_around(state, readings, coefficients), prior, weights)
        part = given_rest(fit)
        change, _ = _within_bounds(fit, part.information)
        y = np.append(change, 1.0)
        e = part.gain @ y
        weights = fit.weights_at(y, e)
        coefficients = (e + fit.shift @ y).reshape(coefficients.shape)
        state = fit.state.changed(change)
        shift = np.abs(fit.columns[:, :, :-1] @ change).max()
        shift /= min(noise.space for noise in state.noises)
        if max(shift, np.abs(weights - fit.weights).max()) < CONVERGED:
            break
    state, samples = samples_around(state, readings, coefficients)
    nu = state.degrees
    fit = CurveFit(state, samples, prior, weights * (nu + 3) / (nu + 5))
    part = given_rest(fit)
    _, covariance = _within_bounds(fit, part.information, widened=True)
    joint = with_curves(fit, part, covariance)
    marginal = replace(fit, weights=weights * nu / (nu + 3))
    return _posterior(posterior, marginal, coefficients, joint, evidence)


def _within_bounds(
    fit: CurveFit, information: np.ndarray, *, widened: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return as :func:`posterior_of_rest`, by the moments of what is never negative."""
    state = fit.state
    change, covariance = posterior_of_rest(state, fit.rest, information)
    bounds, slope, _ = factors_of_bounds(state, change, covariance)
    precision, gradient = priors_of_rest(state, widened=widened)
    equations = precision + np.diag(bounds), gradient + slope
    return posterior_of_rest(state, equations, information)


def _posterior(
    posterior: FitPosterior,
    marginal: CurveFit,
    curves: np.ndarray,
    joint: np.ndarray,
    evidence: float,
) -> FitPosterior:
    """Return the result with curves, (KNOTS, m), last in the covariance, in their place."""
    flat, state, size = posterior.objective, marginal.state, posterior.model.size
    model = posterior.model.with_effects((*posterior.model.extensions, CURVE.name))
    process = CurvePrior(marginal.prior.amplitude, marginal.prior.length)
    covariance = submatrix(
        joint, np.r_[:size, flat.size : len(joint), size : flat.size]
    )
    knots = size + np.arange(curves.size).reshape(curves.shape)
    groups = [
        replace(group, members=group.members + curves.size * (group.members >= size))
        for group in state.groups
    ]
    groups.append(_curve_group(model, knots, process, covariance))
    coefficients = curves.ravel()
    state = replace(
        state,
        objective=replace(flat, model=model),
        x=np.insert(state.x, size, coefficients),
        at_zero=np.insert(state.at_zero, size, np.zeros(curves.size, dtype=bool)),
        groups=tuple(groups),
    )
    iterates = [
        np.insert(iterate, size, 0 * coefficients) for iterate in posterior.iterates
    ]
    iterates.append(state.x)
    return FitPosterior(
        state, posterior.around, marginal.weights, evidence, iterates, covariance
    )


def _curve_group(
    model: ExtendedModel, knots: np.ndarray, prior: CurvePrior, covariance: np.ndarray
) -> PriorGroup:
    """Return the prior of curves by their places in the covariance, (KNOTS, m)."""
    effective = 0.0
    for column, joint in zip(knots.T, model.robot.actuated, strict=True):
        if joint.type != "prismatic":
            effective += KNOTS - float(
                np.sum(prior.inverse * submatrix(covariance, column))
            )
    return PriorGroup(
        CURVE.name,
        CURVE.unit,
        knots.ravel(),
        prior.amplitude,
        effective=effective,
        length=prior.length,
        optional=True,
    )
