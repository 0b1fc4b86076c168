"""The iteration to the most probable unknowns, prior widths and noise."""

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from ...data import MultiRobotObservations
from ...paper import NotConverged
from ..model import NEGLIGIBLE, SMALLEST, ExtendedModel, Movement
from .laplace import posterior
from .normal_equations import NormalEquations, active_set_step, leverage, normal_equations, value
from .objective import (
    Objective,
    State,
    build_objective,
    free_unknowns,
    prior_gradient,
    prior_precision,
)
from .posterior import JointPosterior
from .state import (
    Step,
    effect_of,
    following_noise,
    moved,
    prune_groups,
    start,
    updated_groups,
    updated_noises,
    with_degrees_of_freedom,
)

MAX_ITERATIONS = 300
RESTLESS, CALM = 100, 0.5
"""Iterations after which the logarithm of a width changes by no more than this in one: two groups
that explain the same may else take turns for ever."""
SETTLED = 1e-2
"""Relative change of the widths and the noise at which the iteration ends."""
SETTLED_EXACT = 1e-4
"""The same where the data are exact: steps along what they hardly show still count then."""
FALL = 2.0
"""Slope of L along a step, twice of what the step lowers it by, beyond which the iteration goes on:
where widths and noise did not change by chance, the unknowns may still be on their way."""
LEAVES = 2
"""Times that a joint's elasticity may leave zero. One that gains nothing could else come and go
forever."""
SHORTER = 6
RISE = 1e-9
"""Relative rise of the objective in a step that is rounding alone."""


def estimate(
    models: Sequence[ExtendedModel],
    data: MultiRobotObservations,
    *,
    joint_noise: bool = True,
    near: JointPosterior | None = None,
    movements: Sequence[Movement] = (),
) -> JointPosterior:
    """Find the most probable unknowns of one robot or several, fitted together.

    It starts from a result ``near`` for the same robots, or else from the nominal ones. Without
    ``joint_noise`` that of the joint angles is zero.

    Raises:
        NotConverged: The widths and the noise did not settle.
        FrameError: Nothing ties a frame to the robot, or its coordinates cannot be.
    """
    objective = build_objective(models, data, movements)
    state: State = start(objective, joint_noise, near)
    iterates: list[np.ndarray] = [state.x]
    left = np.zeros(len(state.x), dtype=int)
    try:
        for count in range(MAX_ITERATIONS):
            held, step = state.at_zero, gauss_newton(objective, state, left < LEAVES)
            state, change = _advance(objective, state, step, np.inf if count < RESTLESS else CALM)
            left += held & ~state.at_zero
            iterates.append(state.x)
            noisy = any(noise.space > SMALLEST for noise in state.noises)
            if change >= (SETTLED if noisy else SETTLED_EXACT) or step.slope < -FALL:
                continue
            pruned = prune_groups(objective, state)
            if pruned is not state:
                state = pruned
            else:
                return posterior(objective, state, iterates)
    except np.linalg.LinAlgError:
        raise NotConverged("auto diverged; see mukca check, or try --method paper") from None
    raise NotConverged(f"auto did not settle in {MAX_ITERATIONS} iterations; see mukca check")


def gauss_newton(objective: Objective, state: State, may_leave: np.ndarray | bool = True) -> Step:
    """Return the step to the minimum of L's quadratic approximation."""
    normal = normal_equations(objective, state)
    prior = prior_precision(objective, state)
    free = free_unknowns(objective, state)
    covariance = normal.information.plus(prior).inverse(free[: objective.dense])
    spread = leverage(objective, state, covariance)
    spread = normal.told[:, None, None] * spread
    volume = _volume_weight(objective, state, normal, spread)
    bounded = np.zeros(objective.size, dtype=bool)
    for group in state.groups:
        bounded[group.members] = group.non_negative and group.width > 0
    held = state.at_zero & ~(may_leave & bounded[: objective.model.size])
    released = replace(state, at_zero=held)
    unheld = covariance
    if (held != state.at_zero).any():
        prior, unheld = prior_precision(objective, released), None
    x = np.concatenate([state.x, np.zeros(objective.size - len(state.x))])
    gradient = (
        normal.gradient + prior_gradient(objective, state, prior) + volume * state.linear.by_volume
    )
    free = free_unknowns(objective, released)
    H = normal.information.plus(prior)
    change, covariance = active_set_step(H, gradient, x, free, bounded & free, unheld)
    return Step(change, covariance, normal, spread, volume, float(gradient @ change))


def _volume_weight(
    objective: Objective, state: State, normal: NormalEquations, spread: np.ndarray
) -> float:
    """Return by how much to multiply the volume's slope: as the errors' squares fit the noise.

    While the noise is still too large or small, all of it would let size and noise run away.
    """
    seated = objective.rows.seated
    weights = normal.weights[seated]
    if not state.x.any() or not len(weights):
        return 0.0
    squares = float(weights @ normal.squares[seated])
    total = 3 * len(weights)
    left = total - float(np.sum(normal.inverse_scales[seated] * spread[seated]))
    return squares / left if left > 0.5 * total else 1.0


def _advance(objective: Objective, state: State, step: Step, most: float) -> tuple[State, float]:
    """Return the state after a step of everything, and the largest relative change of a scale."""
    there, step = _downhill(objective, state, step)
    linear = there.linear
    groups, change = state.groups, 1.0
    noises = updated_noises(objective, state, there, step)
    # -slope is the step's length squared, in standard deviations of the unknowns
    if -step.slope < objective.size:
        groups, change = updated_groups(
            there, there.x, step.covariance.dense, lambda g: effect_of(there, g) > NEGLIGIBLE, most
        )
        noises = with_degrees_of_freedom(objective, there, noises, step)
    groups = following_noise(objective, groups, noises)
    for source, before, noise in zip(objective.rows.sources, state.noises, noises, strict=True):
        change = max(change, abs(log(noise.space / before.space)))
        if before.joint_effect(linear.by_joints[source]) > NEGLIGIBLE:
            change = max(change, abs(log(noise.joint / before.joint)))
    return replace(there, groups=groups, noises=noises), change


def _downhill(objective: Objective, state: State, step: Step) -> tuple[State, Step]:
    """Return the state after a step, and the step taken."""
    before = value(objective, state, step.volume, step.normal)
    for _ in range(SHORTER):
        there = _moved(objective, state, step.change)
        rise = value(objective, there, step.volume) - before
        if rise <= RISE * abs(before):
            break
        part = min(0.5, max(0.1, -0.5 * step.slope / (rise - step.slope)))
        step = replace(step, change=part * step.change, slope=part * step.slope)
    else:
        there = _moved(objective, state, step.change)
    return there, step


def _moved(objective: Objective, state: State, change: np.ndarray) -> State:
    """Return the state after a change of all unknowns: a joint never gives way against its load."""
    at_zero = state.at_zero.copy()
    for group in state.groups:
        if group.non_negative:
            at_zero[group.members] = (state.x + change[: len(state.x)])[group.members] <= 0
    return replace(moved(objective, state, change), at_zero=at_zero)
