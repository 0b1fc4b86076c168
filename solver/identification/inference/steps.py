"""States of the estimation after steps of unknowns, widths and noise."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from ..model import (
    NEGLIGIBLE,
    Noise,
    PriorGroup,
    degrees_of_freedom,
    joint_reach,
    submatrix,
)
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

    def shortened(self, share: float) -> "Step":
        """Return a share of the step."""
        change, slope = share * self.change, share * self.slope
        return replace(self, change=change, slope=slope)


def moved(state: State, change: np.ndarray) -> State:
    """Return the state after a change of all unknowns, sockets going along with their balls.

    Left on the tangent, a centre would be a reason not to turn the whole robot.
    """
    data = state.objective.data
    next_state = state.changed(change).linearised()
    off_tangent = next_state.errors - state.predicted_errors(change)
    counts = np.bincount(data.seated_sockets)
    shifts = data.by_socket(off_tangent) / counts[:, None]
    measured_sockets = [place.socket for place in data.located]
    shifts[measured_sockets] = 0.0
    return replace(next_state, centres=next_state.centres + shifts)


def updated_groups(
    state: State,
    x: np.ndarray,
    covariance: np.ndarray,
    counts: Callable[[PriorGroup], bool],
    largest: float = np.inf,
) -> tuple[tuple[PriorGroup, ...], float]:
    """Return the groups after a step of their widths (A4), and the largest relative change.

    The change is that of groups that count.
    """
    groups = list(state.groups)
    largest_change = 0.0
    for k, group in enumerate(state.groups):
        mask = ~state.at_zero[group.members]
        if not (group.learned and group.width and mask.any()):
            continue
        members = group.members[mask]
        offset = x[members] - group.mean[mask]
        of_members = submatrix(covariance, members)
        groups[k] = group.updated(offset, of_members, mask, largest)
        if counts(groups[k]):
            change = abs(log(groups[k].width / group.width))
            largest_change = max(largest_change, change)
    return tuple(groups), largest_change


def updated_noises(state: State, next_state: State, step: Step) -> tuple[Noise, ...]:
    """Return the noises after a step of s_x^2, and of s_q^2 unless it is zero (A5).

    With V_a = dC_i / ds_a^2, which is I for s_x and Jq_i Jq_i^T for s_q, the step F^-1 g has

        g_a = sum_i w_i u_i^T V_a u_i - tr(V_a R_i)        u_i = C_i^-1 e_i
        F_ab = sum_i tr(C_i^-1 V_a C_i^-1 V_b)             R_i = C_i^-1 - C_i^-1 L_i C_i^-1

    A fit makes errors smaller than the noise was: each unknown uses up some (restricted maximum
    likelihood, Harville 1977). The step is Fisher scoring.
    """
    C_inverse, Jq = state.inverse_scales, state.linear.by_joints
    R = C_inverse - C_inverse @ step.leverage @ C_inverse
    e = state.predicted_errors(step.change)
    u = np.einsum("nij,nj->ni", C_inverse, e)
    outer = u[:, :, None] * u[:, None]
    squares = state.weights[:, None, None] * outer
    by_space = np.broadcast_to(np.eye(3), R.shape)
    by_joints = Jq @ Jq.transpose(0, 2, 1)
    slopes = np.array([by_space, by_joints])
    sources = state.objective.data.sources
    noises: list[Noise] = []
    for rows, noise in zip(sources, state.noises, strict=True):
        scales = 2 if noise.joint else 1
        V = slopes[:scales, rows]
        excess = squares[rows] - R[rows]
        g: np.ndarray = np.einsum("anij,nij->a", V, excess)
        scaled = C_inverse[rows] @ V
        F: np.ndarray = np.einsum("anij,bnji->ab", scaled, scaled)
        reach = joint_reach(next_state.linear.by_joints[rows])
        change = np.linalg.solve(F, g)
        noises.append(noise.updated(change, reach))
    return tuple(noises)


def with_tails(
    noises: Sequence[Noise],
    sources: np.ndarray,
    squares: np.ndarray,
    freedom: np.ndarray,
) -> tuple[Noise, ...]:
    """Return the noises with tails by the squares of (A2), of which a fit left some shares."""
    squares = squares / freedom.clip(min=1 - MOST_HIDDEN)
    updated: list[Noise] = []
    for k, noise in enumerate(noises):
        nu = degrees_of_freedom(squares[sources == k])
        updated.append(replace(noise, nu=nu))
    return tuple(updated)


def without_negligible(
    noises: Sequence[Noise],
    sources: np.ndarray,
    by_joints: np.ndarray,
) -> tuple[Noise, ...]:
    """Return the noises without that of joints where it does hardly anything."""
    updated: list[Noise] = []
    for k, noise in enumerate(noises):
        effect = noise.joint_effect(by_joints[sources == k])
        if effect < NEGLIGIBLE:
            noise = replace(noise, joint=0.0)
        updated.append(noise)
    return tuple(updated)


def following_noise(
    groups: tuple[PriorGroup, ...],
    noises: tuple[Noise, ...],
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
    square = float(np.sum(state.linear.reach[members]))
    precision = min(noise.space for noise in state.noises)
    return group.width * square**0.5 / precision


def prune_groups(state: State) -> State:
    """Return the state without extensions and joint noise that do hardly anything."""
    sources = state.objective.data.source_of
    noises = without_negligible(state.noises, sources, state.linear.by_joints)
    negligible = [
        k
        for k, group in enumerate(state.groups)
        if group.optional and group.width and effect_of(state, group) < NEGLIGIBLE
    ]
    if not negligible and noises == state.noises:
        return state
    change = np.zeros(state.objective.size)
    at_zero = state.at_zero.copy()
    groups = list(state.groups)
    for k in negligible:
        group = groups[k]
        change[group.members] = -state.x[group.members]
        at_zero[group.members] = True
        groups[k] = replace(group, width=0.0, effective=0.0, learned=False)
    state = replace(
        state,
        at_zero=at_zero,
        groups=tuple(groups),
        noises=noises,
    )
    return moved(state, change)
