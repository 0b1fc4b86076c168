"""The fit of each joint's error curve together with everything else."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..model import SMALLEST, ExtendedModel, PriorGroup
from ..model.effects import CURVE, KNOTS
from .curve_marginal import LONGEST, CurveFit, log_evidence, marginalised
from .curve_posterior import MOST_SAMPLES, given_rest, with_curves
from .curve_prior import CurvePrior, given_curves
from .curve_score import promised_gain
from .laplace import expectation_propagation
from .linear_samples import LinearSamples, posterior_of_rest, priors_of_rest, samples_around
from .posterior import JointPosterior
from .state import State

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


def _may_have_curves(found: JointPosterior) -> bool:
    """Return True where curves are identifiable: by points or two placements, without play."""
    measured = any((arm.sockets < 0).any() for arm in found.scene.arms)
    plays = any(g.width for arm in found.arms for g in arm.groups if g.follows_noise)
    noises = [noise.space for arm in found.arms for noise in arm.noises.values()]
    exact = min(noises) <= EXACT * SMALLEST
    return not exact and not plays and (measured or len(found.scene.placements) > 1)


def with_joint_curves(
    found: JointPosterior,
    other: tuple[JointPosterior, float] | None,
    progress: Callable[[str], None],
) -> tuple[JointPosterior, str]:
    """Return a result with error curves of its joints where the data support them, and why.

    In sockets it takes two placements: at one, geometry explains as much. Joints with play hide
    curves. Where none can be found there are no words. ``other`` is the result of another model
    that may be more probable beside curves, and the logarithm of its odds before the data.
    """
    prior = given_curves(found.models)
    if prior is None and not _may_have_curves(found):
        return found, ""
    progress(CURVE.extension)
    try:
        return _with_joint_curves(found, other, prior)
    except np.linalg.LinAlgError:  # of exact data, say, which leave no noise
        return found, "not supported by the data (with them, the fit does not settle)"


def _with_joint_curves(
    found: JointPosterior,
    other: tuple[JointPosterior, float] | None,
    prior: CurvePrior | None,
) -> tuple[JointPosterior, str]:
    around = samples_around(found.state, found.objective.rows)
    n = len(around[1].sources)
    if prior is not None:
        rows = _random_rows(n, MOST_SAMPLES)
        fitted = marginalised(_fit_of(around, rows, prior))
        return _converged(found, rows, fitted, found.log_evidence), GIVEN
    state, fitted = around[0], None
    for most in (FIRST_SAMPLES, MOST_SAMPLES):
        rows = _random_rows(n, most)
        flat = _fit_of(around, rows, CurvePrior(0.0, LONGEST))
        plain = marginalised(replace(flat, state=state))
        if promised_gain(plain) < HINT:
            return found, "not supported by the data (they would not raise the evidence)"
        state, first = plain.state, fitted or _initial_scales(plain)
        begun = replace(plain, state=first.state, prior=first.prior, weights=plain.next_weights)
        fitted = marginalised(begun)
        before, after = log_evidence(plain), log_evidence(fitted)
        gain = after - before
        if gain <= HINT or len(rows) == n:
            break
    evidence = f"(log evidence {gain:+.1f})"
    if not gain > LOG_EVIDENCE:
        return found, f"not supported by the data {evidence}"
    chosen, whole = found, found.log_evidence - before
    if other is not None:
        beside = samples_around(other[0].state, found.objective.rows)
        fit = _fit_of(beside, rows, fitted.prior)
        near = replace(fit.state, noises=fitted.state.noises)
        fit = marginalised(replace(fit, state=near, weights=fitted.next_weights))
        evidence_beside = log_evidence(fit)
        if evidence_beside + other[1] > after:
            chosen, fitted, after = other[0], fit, evidence_beside
    return _converged(chosen, rows, fitted, whole + after), f"kept {evidence}"


def _fit_of(around: tuple[State, LinearSamples], rows: np.ndarray, prior: CurvePrior) -> CurveFit:
    """Return the fit to some of the samples that count alike."""
    state, samples = around
    return CurveFit(state, samples.of(rows), prior, np.ones(len(rows)))


def _random_rows(count: int, most: int) -> np.ndarray:
    """Return the samples of which the evidence is worked out."""
    ranks: np.ndarray = np.random.default_rng(0).random(count).argsort().argsort()
    return np.flatnonzero(ranks < most)


def _initial_scales(plain: CurveFit) -> CurveFit:
    """Return scales by which curves explain half of the errors, and noise the rest."""
    samples = plain.samples
    square = float(np.median(np.sum(samples.columns[:, :, -1] ** 2, axis=1))) / 2.37  # of chi^2_3
    reaches: np.ndarray = np.sum(samples.slopes**2, axis=(1, 2)) / 3
    half = 0.5**0.5
    noises = tuple(
        replace(one, space=half * one.space, joint=half * one.joint) for one in plain.state.noises
    )
    prior = CurvePrior(half * (square / float(reaches.mean())) ** 0.5, FIRST_LENGTH)
    return replace(plain, state=replace(plain.state, noises=noises), prior=prior)


def _converged(
    found: JointPosterior, rows: np.ndarray, fitted: CurveFit, log_evidence: float
) -> JointPosterior:
    """Return the result at the scales of a fit to some rows, made linear until nothing changes."""
    readings, prior, state = found.objective.rows, fitted.prior, fitted.state
    weights, coefficients = np.ones(len(state.errors)), np.zeros(fitted.samples.shape)
    weights[rows] = fitted.next_weights
    for _ in range(ROUNDS):
        fit = CurveFit(*samples_around(state, readings, coefficients), prior, weights)
        part = given_rest(fit)
        change, _ = _within_bounds(fit, part.information)
        y = np.append(change, 1.0)
        e = part.gain @ y
        weights = fit.weights_at(y, e)
        coefficients = (e + fit.shift @ y).reshape(coefficients.shape)
        state = fit.state.changed(change)
        moved = np.abs(fit.columns[:, :, :-1] @ change).max()
        moved /= min(one.space for one in state.noises)
        if max(moved, np.abs(weights - fit.weights).max()) < CONVERGED:
            break
    state, samples = samples_around(state, readings, coefficients)
    nu = state.degrees
    fit = CurveFit(state, samples, prior, weights * (nu + 3) / (nu + 5))
    part = given_rest(fit)
    _, known = _within_bounds(fit, part.information, widened=True)
    whole = with_curves(fit, part, known)
    fitted = replace(fit, weights=weights * nu / (nu + 3))
    return _posterior(found, fitted, coefficients, whole, log_evidence)


def _within_bounds(
    fit: CurveFit, information: np.ndarray, *, widened: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return as :func:`posterior_of_rest`, by the moments of what is never negative."""
    state = fit.state
    b = np.flatnonzero(state.bounded & state.free)
    precision, gradient = map(np.copy, priors_of_rest(state, widened=widened))
    if len(b):
        change, covariance = posterior_of_rest(state, fit.rest, information)
        x, sigma = state.x[b], covariance[np.ix_(b, b)]
        bounds, pulled, _ = expectation_propagation(x + change[b], sigma)
        precision[b, b] += bounds
        gradient[b] += bounds * x - pulled
    return posterior_of_rest(state, (precision, gradient), information)


def _posterior(
    found: JointPosterior,
    fitted: CurveFit,
    curves: np.ndarray,
    whole: np.ndarray,
    log_evidence: float,
) -> JointPosterior:
    """Return the result with curves, (KNOTS, robots, m), last in the covariance, in their place."""
    readings, state, own = found.objective, fitted.state, found.own
    models = tuple(one.with_effects((*one.extensions, CURVE.name)) for one in found.models)
    world = replace(readings, models=models)
    process = CurvePrior(fitted.prior.amplitude, fitted.prior.length)
    places = readings.size + np.arange(curves.size).reshape(curves.shape)
    order, groups = list[np.ndarray](), list[PriorGroup]()
    for i, model in enumerate(models):
        knots = places[:, i, : len(model.robot.joint_names)]
        order += [np.arange(own[i].start, own[i].stop), knots.ravel()]
        groups.append(_curve_group(model, knots, process, whole))
    picked = np.concatenate([*order, np.arange(int(own[-1].stop), readings.size)])
    place = np.argsort(np.append(picked, np.setdiff1d(np.arange(len(whole)), picked)))

    def arranged(x: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
        rest = np.pad(x, (0, readings.size - len(x)))
        return np.append(rest, coefficients)[picked[: world.model_size]]

    iterates = [arranged(each, 0 * curves) for each in found.iterates]
    x = arranged(state.x, curves)
    groups = [replace(g, members=place[g.members]) for g in (*state.groups, *groups)]
    return JointPosterior(
        replace(state, objective=world, x=x, groups=tuple(groups)),
        found.around,
        fitted.weights,
        log_evidence,
        [*iterates, x],
        whole[np.ix_(picked, picked)],
    )


def _curve_group(
    model: ExtendedModel, knots: np.ndarray, prior: CurvePrior, whole: np.ndarray
) -> PriorGroup:
    """Return the prior of a robot's curves by their places in the covariance, (KNOTS, m)."""
    effective = 0.0
    for own, joint in zip(knots.T, model.robot.actuated, strict=True):
        if joint.type != "prismatic":
            effective += KNOTS - float(np.sum(prior.inverse * whole[np.ix_(own, own)]))
    return PriorGroup(
        CURVE.name,
        CURVE.unit,
        knots.ravel(),
        prior.amplitude,
        effective=effective,
        length=prior.length,
        optional=True,
    )
