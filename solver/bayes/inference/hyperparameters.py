"""The widths of the priors and the noise, which are estimated beside the unknowns."""

from bisect import bisect
from collections.abc import Callable
from dataclasses import replace
from math import log

import numpy as np

from ..model import NEGLIGIBLE, Noise, PriorGroup, degrees_of_freedom
from .normal_equations import predicted_errors, robust_weights
from .objective import Objective, State
from .state import Step, moved

MOST_HIDDEN = 0.9
"""Share of an error that a fit can hide, for all that its tails are judged by."""


def updated_groups(
    state: State,
    x: np.ndarray,
    covariance: np.ndarray,
    counts: Callable[[PriorGroup], bool],
    most: float = np.inf,
) -> tuple[tuple[PriorGroup, ...], float]:
    """Return the groups after a step of their widths (A4), and the largest relative change."""
    groups: list[PriorGroup] = []
    change = 0.0
    for group in state.groups:
        new, free = group, ~state.at_zero[group.members]
        if group.learned and group.width and free.any():
            members = group.members[free]
            off = x[members] - group.mean[free]
            new = group.updated(off, covariance[members[:, None], members], free, most)
            if counts(new):
                change = max(change, abs(log(new.width / group.width)))
        groups.append(new)
    return tuple(groups), change


def updated_noises(
    objective: Objective, state: State, there: State, step: Step
) -> tuple[Noise, ...]:
    """Return the noises after a step of their scales (A5), see :class:`Noise`."""
    by_joints = state.linear.by_joints
    errors = predicted_errors(objective, state, step.change)
    noises: list[Noise] = []
    for source, noise in zip(objective.rows.sources, state.noises, strict=True):
        squares = noise.fisher_step(
            step.normal.inverse_scales[source],
            step.normal.weights[source],
            errors[source],
            step.leverage[source],
            by_joints[source],
        )
        effect = noise.joint_effect(there.linear.by_joints[source])
        noises.append(noise.updated(squares, effect))
    return tuple(noises)


def with_degrees_of_freedom(
    objective: Objective, there: State, noises: tuple[Noise, ...], step: Step
) -> tuple[Noise, ...]:
    """Return the noises with tails as heavy as those of the errors, but for what the fit hides."""
    hidden = np.einsum("nij,nji->n", step.normal.inverse_scales, step.leverage) / 3
    squares = robust_weights(objective, there)[1] / (1 - np.minimum(hidden, MOST_HIDDEN))
    return tuple(
        replace(noise, nu=degrees_of_freedom(squares[source]))
        for source, noise in zip(objective.rows.sources, noises, strict=True)
    )


def following_noise(
    objective: Objective, groups: tuple[PriorGroup, ...], noises: tuple[Noise, ...]
) -> tuple[PriorGroup, ...]:
    """Return the groups, with means that follow the noise of each robot's joints where they do."""
    rows, joint = objective.rows, np.zeros(len(objective.rows.sockets))
    for source, noise in zip(rows.sources, noises, strict=True):
        joint[source] = noise.joint
    noisy = [float(joint[samples].max()) for samples in rows.own]
    starts = [own.start for own in objective.model.own]
    of = [noisy[bisect(starts, group.members[0]) - 1] for group in groups]
    return tuple(
        group.following(noise) if group.follows_noise and group.width and noise else group
        for group, noise in zip(groups, of, strict=True)
    )


def effect_of(state: State, group: PriorGroup) -> float:
    """Return how far a group's width moves the ball, relative to the noise."""
    members = group.members[~state.at_zero[group.members]]
    least = min(noise.space for noise in state.noises)
    return group.width * float(np.sum(state.linear.reach[members])) ** 0.5 / least


def prune_groups(objective: Objective, state: State) -> State:
    """Return the state without extensions and joint noise that do hardly anything."""
    gone = {  # by place: those of two arms may have one name
        i: group
        for i, group in enumerate(state.groups)
        if group.optional and group.width and effect_of(state, group) < NEGLIGIBLE
    }
    noises = tuple(
        replace(noise, joint=0.0)
        if noise.joint and noise.joint_effect(state.linear.by_joints[source]) < NEGLIGIBLE
        else noise
        for source, noise in zip(objective.rows.sources, state.noises, strict=True)
    )
    if not gone and noises == state.noises:
        return state
    x, at_zero = state.x.copy(), state.at_zero.copy()
    for group in gone.values():
        x[group.members], at_zero[group.members] = 0.0, True
    groups = tuple(
        replace(g, width=0.0, effective=0.0, learned=False) if i in gone else g
        for i, g in enumerate(state.groups)
    )
    state = replace(state, at_zero=at_zero, groups=groups, noises=noises)
    change = np.zeros(objective.size)
    change[: len(x)] = x - state.x
    return moved(objective, state, change) if change.any() else state
