"""States of the estimation: the first, and those after steps of unknowns, widths and noise."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from ...data import first_frames
from ..model import (
    NEGLIGIBLE,
    SMALLEST,
    Noise,
    PriorGroup,
    degrees_of_freedom,
    joint_reach,
    prior_groups,
)
from .objective import Objective, linearise
from .posterior import FitPosterior
from .state import State

MOST_HIDDEN = 0.9
"""Share of an error that a fit can hide, for all that its tails are judged by."""


@dataclass(frozen=True)
class Step:
    """A Gauss-Newton step, and what it was computed from."""

    change: np.ndarray
    """Of all unknowns, shape (n,); zero for those that are held."""
    covariance: np.ndarray
    """Inverse of the whole curvature, priors included; zero for what is held."""
    leverage: np.ndarray
    """L_i of (A5), shape (N, 3, 3) [m^2]."""
    volume: float
    """Factor of the volume's slope; 1 where the noise fits the errors."""
    slope: float
    """Slope of L along the change, per whole step."""


def start(
    objective: Objective, joint_noise: bool, previous: FitPosterior | None = None
) -> State:
    """Return the first state: the nominal robot, each socket at the median of its balls."""
    model, data = objective.model, objective.data
    x, at_zero = np.zeros(objective.x_size), np.zeros(objective.x_size, dtype=bool)
    groups = list(prior_groups(model, data))
    for group in groups:
        if group.name in ("ball", "given"):  # known to be anywhere, far from nominal
            x[group.members] = group.mean
    if previous is not None:  # as far as that has them
        before = previous.arm
        _, rows, rows_before = np.intersect1d(
            model.names, before.model.names, return_indices=True
        )
        x[rows] = before.x[rows_before]
        # what the samples never moved is at zero as well, and yet not held there
        at_zero[rows] = previous.state.bounded[rows_before] & (x[rows] == 0)
        by_name = {group.name: group for group in before.groups}
        groups = [_carried_over(group, by_name.get(group.name)) for group in groups]
    begin = model.size
    for movement in objective.movements:
        groups.append(movement.prior(begin))
        begin += movement.size
    points = model.predict(x[: model.size], data.positions, data.torques, data.clocks)
    frames = first_frames(data, points)
    linear = linearise(objective, x, frames)
    sockets = range(data.socket_count)
    places = [np.median(linear.places[data.sockets == k], axis=0) for k in sockets]
    centres = np.reshape(places, (-1, 3))
    state = State(objective, x, centres, frames, tuple(groups), (), at_zero, linear)
    if previous is None:
        pairs = [(state.errors[rows], linear.by_joints[rows]) for rows in data.sources]
        noises = [_nominal_noise(*pair, joint_noise=joint_noise) for pair in pairs]
    else:
        before = previous.arm
        noises = [before.noises.get(kind) or before.noise for kind in data.source_kinds]
    return replace(state, noises=tuple(noises))


def _nominal_noise(
    errors: np.ndarray, by_joints: np.ndarray, *, joint_noise: bool
) -> Noise:
    """Return noise as large as the nominal robot's errors, shape (N, 3) [m]."""
    # The median of chi_3.
    typical = float(np.median(np.linalg.norm(errors, axis=1))) / 1.54
    joint = typical / joint_reach(by_joints) if joint_noise else 0.0
    return Noise(max(typical, SMALLEST), joint)


def _carried_over(group: PriorGroup, before: PriorGroup | None) -> PriorGroup:
    """Return the group of a result, unless other means were expected there."""
    if before is None or before.expected is not group.expected:
        return group
    return replace(before, members=group.members, trail=None)


def moved(state: State, change: np.ndarray) -> State:
    """Return the state after a change of all unknowns, sockets going along with their balls.

    Left on the tangent, a centre would be a reason not to turn the whole robot.
    """
    objective, data = state.objective, state.objective.data
    next_state = state.changed(change)
    linear = linearise(objective, next_state.x, next_state.frames)
    next_state = replace(next_state, linear=linear)
    off_tangent = next_state.errors - state.predicted_errors(change)
    along = data.by_socket(off_tangent) / np.bincount(data.seated_sockets)[:, None]
    along[[socket.socket for socket in data.located]] = 0.0
    return replace(next_state, centres=next_state.centres + along)


def updated_groups(
    state: State,
    x: np.ndarray,
    covariance: np.ndarray,
    counts: Callable[[PriorGroup], bool],
    largest: float = np.inf,
) -> tuple[tuple[PriorGroup, ...], float]:
    """Return the groups after a step of their widths (A4), and the largest relative change."""
    groups: list[PriorGroup] = []
    change = 0.0
    for group in state.groups:
        new, mask = group, ~state.at_zero[group.members]
        if group.learned and group.width and mask.any():
            members = group.members[mask]
            offset = x[members] - group.mean[mask]
            new = group.updated(
                offset, covariance[members[:, None], members], mask, largest
            )
            if counts(new):
                change = max(change, abs(log(new.width / group.width)))
        groups.append(new)
    return tuple(groups), change


def updated_noises(state: State, next_state: State, step: Step) -> tuple[Noise, ...]:
    """Return the noises after a step of s_x^2, and of s_q^2 unless it is zero (A5)."""
    # A fit makes errors smaller than the noise was: each unknown uses up some (restricted maximum
    # likelihood, Harville 1977). The step is Fisher scoring.
    inverse, by_joints = state.inverse_scales, state.linear.by_joints
    u = np.einsum("nij,nj->ni", inverse, state.predicted_errors(step.change))
    remainder = inverse - inverse @ step.leverage @ inverse
    squares = state.weights[:, None, None] * u[:, :, None] * u[:, None]
    by_space = np.broadcast_to(np.eye(3), remainder.shape)
    slopes = np.array([by_space, by_joints @ by_joints.transpose(0, 2, 1)])
    noises: list[Noise] = []
    for source, noise in zip(state.objective.data.sources, state.noises, strict=True):
        V = slopes[: 2 if noise.joint else 1, source]
        score: np.ndarray = np.einsum("anij,nij->a", V, squares[source])
        score -= np.einsum("anij,nij->a", V, remainder[source])
        scaled = inverse[source] @ V
        fisher: np.ndarray = np.einsum("anij,bnji->ab", scaled, scaled)
        reach = joint_reach(next_state.linear.by_joints[source])
        noises.append(noise.updated(np.linalg.solve(fisher, score), reach))
    return tuple(noises)


def with_tails(
    noises: Sequence[Noise],
    sources: np.ndarray,
    squares: np.ndarray,
    freedom: np.ndarray,
) -> tuple[Noise, ...]:
    """Return the noises with tails by the squares of (A2), of which a fit left some shares."""
    squares = squares / freedom.clip(min=1 - MOST_HIDDEN)
    return tuple(
        replace(noise, nu=degrees_of_freedom(squares[sources == k]))
        for k, noise in enumerate(noises)
    )


def without_negligible(
    noises: Sequence[Noise], sources: np.ndarray, by_joints: np.ndarray
) -> tuple[Noise, ...]:
    """Return the noises without that of joints where it does hardly anything."""
    effects = [
        noise.joint_effect(by_joints[sources == k]) for k, noise in enumerate(noises)
    ]
    pairs = zip(noises, effects, strict=True)
    return tuple(
        replace(noise, joint=0.0) if e < NEGLIGIBLE else noise for noise, e in pairs
    )


def following_noise(
    groups: tuple[PriorGroup, ...], noises: tuple[Noise, ...]
) -> tuple[PriorGroup, ...]:
    """Return the groups, with means that follow the noise of the joints where they do."""
    noise = max(noise.joint for noise in noises)
    if not noise:
        return groups
    return tuple(
        group.following(noise) if group.follows_noise and group.width else group
        for group in groups
    )


def effect_of(state: State, group: PriorGroup) -> float:
    """Return how far a group's width moves the ball, relative to the noise."""
    members = group.members[~state.at_zero[group.members]]
    precision = min(noise.space for noise in state.noises)
    return group.width * float(np.sum(state.linear.reach[members])) ** 0.5 / precision


def prune_groups(state: State) -> State:
    """Return the state without extensions and joint noise that do hardly anything."""
    gone = {
        group.name
        for group in state.groups
        if group.optional and group.width and effect_of(state, group) < NEGLIGIBLE
    }
    sources = state.objective.data.source_of
    noises = without_negligible(state.noises, sources, state.linear.by_joints)
    if not gone and noises == state.noises:
        return state
    change, at_zero = np.zeros(state.objective.size), state.at_zero.copy()
    groups: list[PriorGroup] = []
    for group in state.groups:
        if group.name in gone:
            change[group.members] = -state.x[group.members]
            at_zero[group.members] = True
            group = replace(group, width=0.0, effective=0.0, learned=False)
        groups.append(group)
    state = replace(state, at_zero=at_zero, groups=tuple(groups), noises=noises)
    return moved(state, change) if change.any() else state
