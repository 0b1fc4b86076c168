"""Maximum a posteriori estimation whose prior widths and noise are set by the objective.

Each iteration takes a Gauss-Newton step (2), (3) of the objective L, see
:mod:`mukca.solver.auto.objective`, and a fixed-point step of the widths of the priors (4) and of
the noise (5) towards the maximum of the evidence (6), see :mod:`mukca.solver.auto.laplace`. A
group of unknowns that the data do not support ends with a width of nearly zero, and is taken out.
docs/model.md is an introduction.
"""

from dataclasses import dataclass, replace
from math import log

import numpy as np

from ..data.observations import Observations
from ..paper.optimizers import NotConverged
from .deflection import COMPLIANCE, EXTENSIONS
from .extended_model import ExtendedModel
from .laplace import inverse, posterior
from .noise import INFORMATION, NEGLIGIBLE, Noise
from .normal_equations import NormalEquations, leverage, normal_equations, predicted_errors
from .objective import (
    Objective,
    State,
    build_objective,
    free_unknowns,
    linearise,
    prior_precision,
    start,
)
from .posterior import Posterior
from .priors import PriorGroup

__all__ = ["estimate"]

MAX_ITERATIONS = 150
SETTLED = 1e-2
"""Relative change of the widths and the noise at which the iteration ends."""


@dataclass(frozen=True)
class Step:
    """A Gauss-Newton step, and what it was computed from."""

    change: np.ndarray
    """Of all unknowns, shape (n,); zero for those that are held."""
    covariance: np.ndarray
    """Inverse of the whole curvature, priors included, shape (n, n); zero for what is held."""
    normal: NormalEquations


def estimate(model: ExtendedModel, data: Observations, *, joint_noise: bool = True) -> Posterior:
    """Find the most plausible unknowns of a model, starting at the nominal robot.

    Args:
        model: What is unknown.
        data: What was measured.
        joint_noise: Whether the joint angles' noise may be other than zero.

    Raises:
        NotConverged: The widths and the noise did not settle.
    """
    objective = build_objective(model, data)
    state: State = start(objective, joint_noise)
    iterates: list[np.ndarray] = [state.x]
    compliances_may_return = True
    try:
        for _ in range(MAX_ITERATIONS):
            step = _gauss_newton(objective, state)
            state, change = _advance(objective, state, step)
            iterates.append(state.x)
            if change >= SETTLED:
                continue
            pruned = _without_negligible(state)
            if pruned is not state:
                state = pruned
            elif compliances_may_return and _held_compliances(state).any():
                state = replace(state, at_zero=state.at_zero & ~_held_compliances(state))
                compliances_may_return = False
            else:
                return posterior(objective, state, iterates)
    except np.linalg.LinAlgError:
        raise NotConverged("auto diverged; see mukca check, or try --method paper") from None
    raise NotConverged(f"auto did not settle in {MAX_ITERATIONS} iterations; see mukca check")


def _gauss_newton(objective: Objective, state: State) -> Step:
    """Return the step to the minimum of L's quadratic approximation.

        H = curvature of the data's part + P        step = -H^-1 (dL/dx)                   (3)

    See :func:`~mukca.solver.auto.normal_equations.normal_equations` for the data's part.
    """
    normal = normal_equations(objective, state)
    prior = prior_precision(objective, state)
    x = np.concatenate([state.x, np.zeros(state.centres.size)])
    gradient = normal.gradient + prior @ x - objective.by_volume
    covariance = inverse(normal.information + prior, free_unknowns(objective, state))
    return Step(-covariance @ gradient, covariance, normal)


def _advance(objective: Objective, state: State, step: Step) -> tuple[State, float]:
    """Return the state after a step of everything, and the largest relative change of a scale."""
    x, at_zero = _moved(state, step.change[: objective.model.size])
    centres = state.centres + step.change[objective.model.size :].reshape(-1, 3)
    linear = linearise(objective, x, centres)
    moved = replace(state, x=x, centres=centres, at_zero=at_zero, linear=linear)
    groups, change = _updated_groups(moved, step)
    noise = _updated_noise(objective, state, moved, step)
    before = state.noise
    change = max(change, abs(log(noise.space / before.space)))
    if before.joint_effect(linear.by_joints) > NEGLIGIBLE:
        change = max(change, abs(log(noise.joint / before.joint)))
    return replace(moved, groups=groups, noise=noise), change


def _moved(state: State, change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x after a change, and what is held: a joint never bends against its load."""
    x, at_zero = state.x + change, state.at_zero.copy()
    for group in state.groups:
        if group.name == COMPLIANCE:
            below = group.members[x[group.members] < 0]
            x[below] = 0.0
            at_zero[below] = True
    return x, at_zero


def _updated_groups(state: State, step: Step) -> tuple[tuple[PriorGroup, ...], float]:
    """Return the groups after a step of their widths (4), and the largest relative change.

    Widths whose effect is negligible do not count for the change.
    """
    groups: list[PriorGroup] = []
    change = 0.0
    for group in state.groups:
        new = group
        if group.learned:
            members = group.members[~state.at_zero[group.members]]
            new = group.updated(
                state.x[members], step.covariance[np.ix_(members, members)], members
            )
            if _effect(state, new) > NEGLIGIBLE:
                change = max(change, abs(log(new.width / group.width)))
        groups.append(new)
    return tuple(groups), change


def _updated_noise(objective: Objective, state: State, moved: State, step: Step) -> Noise:
    """Return the noise after a step of its scales (5), see :class:`Noise`."""
    weights = step.normal.weights
    spread = leverage(objective, state, step.covariance)
    squares = state.noise.fisher_step(
        step.normal.inverse_scales,
        weights,
        predicted_errors(objective, state, step.change),
        INFORMATION * weights[:, None, None] * spread,
        state.linear.by_joints,
    )
    return state.noise.updated(squares, state.noise.joint_effect(moved.linear.by_joints))


def _effect(state: State, group: PriorGroup) -> float:
    """Return how far a group's width moves the ball, relative to the noise."""
    members = group.members[~state.at_zero[group.members]]
    squares: np.ndarray = np.sum(state.linear.by_unknowns[:, :, members] ** 2, axis=(1, 2)) / 3
    return group.width * float(np.mean(squares)) ** 0.5 / state.noise.space


def _without_negligible(state: State) -> State:
    """Return the state without extensions and joint noise that do hardly anything.

    The very same state where there are none.
    """
    gone = [
        group
        for group in state.groups
        if group.name in EXTENSIONS and group.width and _effect(state, group) < NEGLIGIBLE
    ]
    noise = state.noise
    if noise.joint and noise.joint_effect(state.linear.by_joints) < NEGLIGIBLE:
        noise = replace(noise, joint=0.0)
    if not gone and noise is state.noise:
        return state
    x, at_zero = state.x.copy(), state.at_zero.copy()
    for group in gone:
        x[group.members], at_zero[group.members] = 0.0, True
    groups = tuple(
        replace(g, width=0.0, effective=0.0, learned=False) if g in gone else g
        for g in state.groups
    )
    return replace(state, x=x, at_zero=at_zero, groups=groups, noise=noise)


def _held_compliances(state: State) -> np.ndarray:
    """Return which unknowns are compliances held at zero, though their group has a width."""
    held = np.zeros_like(state.at_zero)
    for group in state.groups:
        if group.name == COMPLIANCE and group.learned:
            held[group.members] = state.at_zero[group.members]
    return held
