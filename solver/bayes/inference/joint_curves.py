"""The fit of each joint's error curve together with everything else."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..model import SMALLEST, ExtendedModel, MultiRobotModel, PriorGroup
from ..model.effects import CURVE, KNOTS, circulant, spectrum
from .curve_hyperparameters import LONGEST, Marginalised, marginalised
from .curve_marginal import CurvePrior
from .curve_posterior import covariance, solve, spline_coefficients
from .given_curves import GivenCurves, given_curves
from .laplace import joint_posterior
from .linear_samples import LinearSamples, linear_samples, rest_of, resumed, with_curves
from .objective import Objective, State, build_objective, linearise
from .posterior import JointPosterior

LOG_EVIDENCE = 10.0
"""Least rise of the logarithm of the evidence by which curves are kept. On arms without curves,
sockets or points, it rose by 2.4 at most in 60 recordings."""
GIVEN = "kept, as an earlier calibration has them and these data change them"
MOST_SAMPLES = 300
"""Of which the evidence is worked out, and with which the curves are fitted without any basis."""
FIRST_SAMPLES, HINT = 100, 1.0
"""Samples that are looked at first, and the rise by them below which curves are not sought on."""
EXACT = 10.0
"""Noise of less than so many times the least that there may be is that of exact data."""
FIRST_LENGTH = 0.08
"""Length at which the search begins [rad]."""
ROUNDS = 8
"""Times that the samples are made linear again."""
STILL = 0.1
"""Displacement of a ball, as a share of the noise, and change of a weight that end the rounds."""


def _may_have_curves(found: JointPosterior) -> bool:
    """Tell whether curves can be told from the rest: in sockets by two placements, without play."""
    arms = found.scene.arms
    measured = any((arm.sockets < 0).any() for arm in arms)
    plays = any(g.width for arm in found.arms for g in arm.groups if g.follows_noise)
    told = given_curves([arm.model for arm in found.arms]) is not None
    if min(arm.noise.space for arm in found.arms) <= EXACT * SMALLEST:
        return told
    return told or ((measured or len(found.scene.placements) > 1) and not plays)


def with_joint_curves(
    found: JointPosterior,
    other: tuple[JointPosterior, float] | None,
    progress: Callable[[str], None],
) -> tuple[JointPosterior, str]:
    """Return a result with error curves of its joints where the data support them, and why.

    In sockets it takes two placements: at one, geometry explains as much. Joints with play hide
    curves. Where none can be found there are no words.

    Args:
        found: The result without curves.
        other: That of another model of the same data, which may be more probable beside curves,
            and the logarithm of its odds against the first before the data.
        progress: Called with a word before curves are tried.
    """
    if not _may_have_curves(found):
        return found, ""
    progress(CURVE.extension)
    try:
        return _with_joint_curves(found, other)
    except np.linalg.LinAlgError:  # of exact data, say, which leave no noise
        return found, "not supported by the data (with them, the fit does not settle)"


def _with_joint_curves(
    found: JointPosterior, other: tuple[JointPosterior, float] | None
) -> tuple[JointPosterior, str]:
    readings, state, samples = _around(found)
    n, given = len(samples.errors), given_curves(readings.model.models)
    if given is not None:
        rows = _drawn(n, MOST_SAMPLES)
        few, prior = given.relative(samples.of(rows), state.x), CurvePrior(*given.scales)
        fitted = marginalised(readings, state, few, prior, np.ones(len(rows)))
        fitted = replace(fitted, log_evidence=found.log_evidence)
        return _settled(found, readings, (rows, few), fitted, given), GIVEN
    plain = fitted = None
    for most in (FIRST_SAMPLES, MOST_SAMPLES):
        rows = _drawn(n, most)
        few, all_alike = samples.of(rows), np.ones(len(rows))
        near, flat = plain.state if plain else state, CurvePrior(0.0, LONGEST)
        plain = marginalised(readings, near, few, flat, all_alike)
        near, prior = (fitted.state, fitted.prior) if fitted else _first(plain.state, few)
        fitted = marginalised(readings, near, few, prior, plain.weights)
        gain = fitted.log_evidence - plain.log_evidence
        if gain <= HINT or len(rows) == n:
            break
    evidence = f"(log evidence {gain:+.1f})"
    if not gain > LOG_EVIDENCE:
        return found, f"not supported by the data {evidence}"
    chosen, whole = found, found.log_evidence - plain.log_evidence
    if other is not None:
        own, near, every = _around(other[0])
        near, some = replace(near, noises=fitted.state.noises), every.of(rows)
        fit = marginalised(own, near, some, fitted.prior, fitted.weights)
        if fit.log_evidence + other[1] > fitted.log_evidence:
            chosen, readings, few, fitted = other[0], own, some, fit
    fitted = replace(fitted, log_evidence=whole + fitted.log_evidence)
    return _settled(chosen, readings, (rows, few), fitted, None), f"kept {evidence}"


def _around(found: JointPosterior) -> tuple[Objective, State, LinearSamples]:
    """Return the objective of a result without curves, its state and the samples around that."""
    models = [arm.model for arm in found.arms]
    readings = build_objective(models, found.scene, [one for one, _, _ in found.movements])
    state = resumed(found, readings)
    none = np.zeros(state.linear.by_joints.shape[::2])
    return readings, state, linear_samples(readings, state, none)


def _drawn(count: int, most: int) -> np.ndarray:
    """Return the samples of which the evidence is worked out."""
    ranks: np.ndarray = np.random.default_rng(0).random(count).argsort().argsort()
    return np.flatnonzero(ranks < most)


def _first(state: State, samples: LinearSamples) -> tuple[State, CurvePrior]:
    """Return scales by which curves explain half of the errors, and noise the rest."""
    square = float(np.median(np.sum(samples.errors**2, axis=1))) / 2.37  # of chi^2_3: per axis
    reaches: np.ndarray = np.sum(samples.slopes**2, axis=(1, 2)) / 3
    half = 0.5**0.5
    noises = tuple(
        replace(one, space=half * one.space, joint=half * one.joint) for one in state.noises
    )
    amplitude = half * (square / float(reaches.mean())) ** 0.5
    return replace(state, noises=noises), CurvePrior(amplitude, FIRST_LENGTH)


def _settled(
    found: JointPosterior,
    readings: Objective,
    few: tuple[np.ndarray, LinearSamples],
    fitted: Marginalised,
    given: GivenCurves | None,
) -> JointPosterior:
    """Return the result at the curves' scales, made linear again until nothing changes.

    It begins at the fit to a few samples, which are given with their places among all.
    """
    prior, n = fitted.prior, len(fitted.state.linear.errors)
    coefficients, weights = spline_coefficients(few[1], prior, fitted.pulls), np.ones(n)
    weights[few[0]] = fitted.weights
    state = _moved(readings, fitted.state, fitted.change)
    if given is not None:
        coefficients = coefficients + given.at(state.x)
    for _ in range(ROUNDS):
        objective, shifts = with_curves(readings, coefficients)
        state = replace(state, linear=linearise(objective, state.x, state.centres, state.frames))
        samples, before = linear_samples(objective, state, shifts), weights
        if given is not None:
            samples = given.relative(samples, state.x)
        if n <= MOST_SAMPLES:
            exact = marginalised(objective, state, samples, prior, weights, learn=False)
            coefficients = spline_coefficients(samples, prior, exact.pulls)
            change, weights = exact.change, exact.weights
        else:
            rest = rest_of(objective, state)
            change, coefficients, weights = solve(samples, state.noises, prior, rest, weights)
        state = _moved(objective, state, change)
        if given is not None:
            coefficients = coefficients + given.at(state.x)
        moved = np.abs(samples.by_rest @ change).max() / min(one.space for one in state.noises)
        if max(moved, np.abs(weights - before).max()) < STILL:
            break
    objective, shifts = with_curves(readings, coefficients)
    state = replace(state, linear=linearise(objective, state.x, state.centres, state.frames))
    samples, rest = (
        linear_samples(objective, state, shifts),
        rest_of(objective, state, widened=True),
    )
    if given is not None:
        samples = given.relative(samples, state.x)
    by_splines = n > MOST_SAMPLES
    whole = covariance(samples, state.noises, prior, rest, weights, by_splines=by_splines)
    if given is not None:
        whole = given.whole(whole)
    weights = weights * samples.degrees(state.noises) / (samples.degrees(state.noises) + 3)
    return _posterior(
        found, readings, replace(fitted, state=state, weights=weights), coefficients, whole
    )


def _moved(objective: Objective, state: State, change: np.ndarray) -> State:
    """Return the state after a change of all unknowns but the curves, its errors left as before."""
    size, dense = objective.model.size, objective.dense
    x, at_zero = state.x + change[:size], state.at_zero.copy()
    for group in state.groups:
        if group.non_negative:
            below = group.members[x[group.members] < 0]
            x[below], at_zero[below] = 0.0, True
    turns = change[size:dense].reshape(-1, 6)
    frames = tuple(pose.moved(turn) for pose, turn in zip(state.frames, turns, strict=True))
    centres = state.centres + change[dense:].reshape(-1, 3)
    return replace(state, x=x, at_zero=at_zero, frames=frames, centres=centres)


def _posterior(
    found: JointPosterior,
    readings: Objective,
    fitted: Marginalised,
    coefficients: np.ndarray,
    whole: np.ndarray,
) -> JointPosterior:
    """Return the result with the curves, of shape (robots, m, KNOTS), among each robot's unknowns.

    ``whole`` is the covariance of all other unknowns, then of the curves.
    """
    models = tuple(
        replace(arm.model, extensions=(*arm.model.extensions, CURVE.name)) for arm in found.arms
    )
    world, state = MultiRobotModel(models, readings.model.movements), fitted.state
    m, end = coefficients.shape[1], int(readings.model.own[-1].stop)
    order, x, groups = list[np.ndarray](), list[np.ndarray](), list[PriorGroup]()
    for i, (own, model) in enumerate(zip(readings.model.own, models, strict=True)):
        joints, begin = len(model.robot.joint_names), world.own[i].start
        knots = readings.size + (i * m + np.arange(joints)) * KNOTS
        order += [np.arange(own.start, own.stop), (np.arange(KNOTS)[:, None] + knots).ravel()]
        x += [state.x[own], coefficients[i, :joints].T.ravel()]
        mine = [g for g in state.groups if own.start <= g.members[0] < own.stop]
        groups += [replace(g, members=g.members - own.start + begin) for g in mine]
        members = begin + np.arange(model.slices[-1].start, model.size, dtype=np.int64)
        groups.append(_curve_group(model, members, fitted.prior, whole, knots))
    moving = [g for g in state.groups if g.members[0] >= end]
    groups += [replace(g, members=g.members - end + world.own[-1].stop) for g in moving]
    x.append(state.x[end:])
    picked = np.concatenate([*order, np.arange(end, readings.size)])
    state = replace(state, x=np.concatenate(x), groups=tuple(groups))
    sizes = [(0, one.size - arm.model.size) for one, arm in zip(models, found.arms, strict=True)]
    rounds = zip(*(arm.iterates for arm in found.arms), strict=True)
    iterates = [np.concatenate(list(map(np.pad, each, sizes))) for each in rounds]
    return joint_posterior(
        replace(readings, model=world),
        state,
        whole[np.ix_(picked, picked)],
        fitted.weights,
        fitted.log_evidence,
        [*iterates, state.x],
    )


def _curve_group(
    model: ExtendedModel,
    members: np.ndarray,
    prior: CurvePrior,
    whole: np.ndarray,
    knots: np.ndarray,
) -> PriorGroup:
    """Return the prior of a robot's curves; of each joint, the covariance begins at its knots."""
    effective, inverse = 0.0, circulant(1 / spectrum(prior.length))
    for begin, joint in zip(knots.tolist(), model.robot.actuated, strict=True):
        if joint.type != "prismatic":
            own = slice(begin, begin + KNOTS)
            effective += KNOTS - float(np.sum(inverse * whole[own, own])) / prior.amplitude**2
    return PriorGroup(
        CURVE.name,
        CURVE.unit,
        members,
        prior.amplitude,
        effective=effective,
        length=prior.length,
        optional=True,
    )
