"""The iteration to the most probable unknowns, prior widths and noise."""

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from ....errors import NotConverged
from ..data import Observations
from ..model import NEGLIGIBLE, SMALLEST, Difference, ExtendedModel
from .laplace import posterior
from .normal_equations import (
    BoundedProblem,
    data_equations,
    leverage,
    prior_equations,
)
from .objective import Objective
from .posterior import FitPosterior
from .start import start
from .state import State
from .steps import (
    Step,
    effect_of,
    following_noise,
    moved,
    prune_groups,
    updated_groups,
    updated_noises,
    with_tails,
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
DIVERGED = "the fit diverged: run mukca check on the recordings, or try --method paper"
UNSETTLED = (
    f"the fit did not settle in {MAX_ITERATIONS} iterations: "
    "run mukca check on the recordings"
)
RISE = 1e-9
"""Relative rise of the objective in a step that is rounding alone."""


def estimate(
    model: ExtendedModel,
    data: Observations,
    *,
    joint_noise: bool = True,
    start_from: FitPosterior | None = None,
    differences: Sequence[Difference] = (),
    average_widths: bool = True,
) -> FitPosterior:
    """Find the most probable unknowns of a robot.

    It starts from a result ``start_from`` for the same robot, or else from the nominal one.
    Without ``joint_noise`` the noise of the joint angles is zero; without ``average_widths``
    :attr:`.FitPosterior.over_widths` is still to be taken.

    Raises:
        NotConverged: The widths and the noise did not settle.
        FrameError: Nothing ties a frame to the robot, or its coordinates cannot be.
    """
    objective = _objective(model, data, differences)
    state = start(objective, start_from, joint_noise=joint_noise)
    try:
        result = _iterated(state)
        return result.over_widths if average_widths else result
    except np.linalg.LinAlgError:
        raise NotConverged(DIVERGED) from None


def _iterated(state: State) -> FitPosterior:
    """Return the posterior where unknowns, widths and noise settle."""
    iterates = [state.x]
    departures = np.zeros(len(state.x), dtype=int)
    for count in range(MAX_ITERATIONS):
        at_zero = state.at_zero
        step = gauss_newton(state, may_leave=departures < LEAVES)
        limit = np.inf if count < RESTLESS else CALM
        state, change = _advance(state, step, limit)
        departures += at_zero & ~state.at_zero
        iterates.append(state.x)
        noisy = any(noise.space > SMALLEST for noise in state.noises)
        settled = SETTLED if noisy else SETTLED_EXACT
        if change >= settled or step.slope < -FALL:
            continue
        pruned = prune_groups(state)
        if pruned is state:
            return posterior(state, iterates)
        state = pruned
    raise NotConverged(UNSETTLED)


def refit(
    result: FitPosterior,
    model: ExtendedModel | None = None,
    differences: Sequence[Difference] | None = None,
    *,
    average_widths: bool = True,
) -> FitPosterior:
    """Return a fit of the same data that starts from a result, of its own model or of another.

    Raises as :func:`estimate`.
    """
    if differences is None:
        differences = result.objective.differences
    return estimate(
        model or result.model,
        result.data,
        start_from=result,
        differences=differences,
        average_widths=average_widths,
    )


def stepped(result: FitPosterior, data: Observations) -> State:
    """Return the state one Gauss-Newton step from a result, which some of its samples have left.

    Widths and noise stay as they are. Where a part of the samples leaves, the unknowns move by so
    little that further steps change predictions by micrometres.

    Raises:
        FrameError: Nothing ties a frame to the robot any more.
    """
    objective = _objective(result.model, data, result.objective.differences)
    state = start(objective, result)
    step = gauss_newton(state, may_leave=np.zeros_like(state.at_zero))
    return moved(state, step.change)


def _objective(
    model: ExtendedModel,
    data: Observations,
    differences: Sequence[Difference],
) -> Objective:
    """Return the objective, with the differences of placements that are among the data."""
    of_data = (d for d in differences if {*d.placements} <= {*data.placements})
    return Objective(model, (*of_data,), data)


def gauss_newton(state: State, may_leave: np.ndarray) -> Step:
    """Return the step to the minimum of L's quadratic approximation."""
    data = data_equations(state)
    equations = data + prior_equations(state)
    covariance = equations.arrow(state.free).inverse
    spread = state.information[:, None, None] * leverage(state, covariance)
    volume = _volume_weight(state, spread)
    bounded = state.bounded
    leaves = state.at_zero & may_leave & bounded[: len(state.x)]
    inverse: np.ndarray | None = covariance
    if leaves.any():
        state = replace(state, at_zero=state.at_zero & ~leaves)
        equations, inverse = data + prior_equations(state), None
    equations = equations.tilted(volume * state.linear.volume.slope)
    free = state.free
    problem = BoundedProblem(equations, state.padded, free, bounded & free)
    change, covariance = problem.solution(inverse)
    return Step(
        change=change,
        covariance=covariance,
        leverage=spread,
        volume=volume,
        slope=float(equations.g @ change),
    )


def _volume_weight(state: State, spread: np.ndarray) -> float:
    """Return by how much to multiply the volume's slope: as the errors' squares fit the noise.

    It is sum_i w_i e_i^T C_i^-1 e_i / sum_i (3 - tr(C_i^-1 L_i)), over samples in sockets.
    """
    # While the noise is still too large or small, all of it would let size and noise run away.
    in_socket = state.objective.data.seated
    weights = state.weights[in_socket]
    if not state.x.any() or not len(weights):
        return 0.0
    squares = float(weights @ state.squares[in_socket])
    total = 3 * len(weights)
    traces = state.inverse_scales[in_socket] * spread[in_socket]
    freedom = total - float(np.sum(traces))
    return squares / freedom if freedom > 0.5 * total else 1.0


def _advance(state: State, step: Step, limit: float) -> tuple[State, float]:
    """Return the state after a step of everything, and the largest relative change of a scale."""
    next_state, step = _downhill(state, step)
    data = state.objective.data
    groups, change = state.groups, 1.0
    noises = updated_noises(state, next_state, step)
    # -slope is the step's length squared, in standard deviations of the unknowns
    if -step.slope < state.objective.size:
        groups, change = updated_groups(
            next_state,
            next_state.x,
            step.covariance,
            lambda group: effect_of(next_state, group) > NEGLIGIBLE,
            limit,
        )
        C_inverse, L = state.inverse_scales, step.leverage
        traces: np.ndarray = np.einsum("nij,nji->n", C_inverse, L)
        freedom = 1 - traces / 3
        noises = with_tails(noises, data.source_of, next_state.squares, freedom)
    groups = following_noise(groups, noises)
    for k, rows in enumerate(data.sources):
        before, noise = state.noises[k], noises[k]
        by_space = log(noise.space / before.space)
        change = max(change, abs(by_space))
        effect = before.joint_effect(next_state.linear.by_joints[rows])
        if effect > NEGLIGIBLE:
            by_joint = log(noise.joint / before.joint)
            change = max(change, abs(by_joint))
    return replace(next_state, groups=groups, noises=noises), change


def _downhill(state: State, step: Step) -> tuple[State, Step]:
    """Return the state after a step, and the step taken."""
    before = state.value(step.volume)
    for _ in range(SHORTER):
        next_state = moved(state, step.change)
        rise = next_state.value(step.volume) - before
        if rise <= RISE * abs(before):
            return next_state, step
        share = -0.5 * step.slope / (rise - step.slope)  # the top of the parabola
        share = min(0.5, max(0.1, share))
        step = step.shortened(share)
    return moved(state, step.change), step
