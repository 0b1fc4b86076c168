"""The first state of the estimation: the nominal robot, or what an earlier fit found."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..data import Observations, first_frames
from ..model import SMALLEST, Noise, PriorGroup, joint_reach, prior_groups, put_on_anew
from .objective import Linearization, Objective, linearise
from .posterior import FitPosterior
from .state import State

MEDIAN_OF_CHI_3 = 1.54
"""Median length of a vector of three standard normal numbers."""


def start(
    objective: Objective,
    previous: FitPosterior | None = None,
    *,
    joint_noise: bool = True,
) -> State:
    """Return the first state: each socket is at the median of its balls.

    They are those of a result ``previous``, which tells the noise, too, or of the nominal robot.
    Without ``joint_noise`` the latter's joints have none.
    """
    model, data = objective.model, objective.data
    x = np.zeros(objective.x_size)
    at_zero = np.zeros(objective.x_size, dtype=bool)
    groups = list(prior_groups(model, data))
    for group in groups:
        if group.name in ("ball", "given"):  # known to be anywhere, far from nominal
            x[group.members] = group.mean
    if previous is not None:
        groups = _carry_over(objective, previous, groups, x, at_zero)
    begin = model.size
    for difference, size in zip(objective.differences, objective.sizes, strict=True):
        group = difference.prior(begin, size)
        alone = len(data.frames) == len(difference.placements)
        if difference.course == "each" and alone and not data.seated.any():
            # targets of an instrument, however far from each other they were put on
            group = replace(group, expected=put_on_anew(model, data, size))
            x[group.members] = group.mean
        groups.append(group)
        if previous is not None and difference in previous.objective.differences:
            x[begin : begin + size] = previous.unknowns_of(difference)
        begin += size
    points = model.predict(x, data)
    frames = first_frames(data, points)
    linear = linearise(objective, x, frames)
    state = State(
        objective=objective,
        x=x,
        centres=_centres(linear, data),
        frames=frames,
        groups=tuple(groups),
        noises=(),
        at_zero=at_zero,
        linear=linear,
    )
    if previous is None:
        noises = _nominal_noises(state, joint_noise=joint_noise)
    else:
        usual = previous.state.noises
        before = dict(zip(previous.data.source_kinds, usual, strict=True))
        noises = [before.get(kind, usual[0]) for kind in data.source_kinds]
    return replace(state, noises=tuple(noises))


def _centres(linear: Linearization, data: Observations) -> np.ndarray:
    """Return the median of the balls in each socket, shape (S, 3) [m]."""
    medians = [np.median(linear.places[rows], axis=0) for rows in data.in_sockets]
    return np.reshape(medians, (-1, 3))


def _carry_over(
    objective: Objective,
    previous: FitPosterior,
    groups: Sequence[PriorGroup],
    x: np.ndarray,
    at_zero: np.ndarray,
) -> list[PriorGroup]:
    """Put a result's unknowns into x and at_zero as far as it has them, and return its priors."""
    _, rows, rows_before = np.intersect1d(
        objective.model.names, previous.model.names, return_indices=True
    )
    x[rows] = previous.state.x[rows_before]
    # what the samples never moved is at zero as well, and yet not held there
    bounded = previous.state.bounded[rows_before]
    at_zero[rows] = bounded & (x[rows] == 0)
    by_name = {group.name: group for group in previous.groups}
    return [_prior_after(group, by_name.get(group.name)) for group in groups]


def _prior_after(group: PriorGroup, before: PriorGroup | None) -> PriorGroup:
    """Return the group of a result, unless other means were expected there."""
    if before is None or before.expected is not group.expected:
        return group
    return replace(before, members=group.members, trail=None)


def _nominal_noises(state: State, *, joint_noise: bool) -> list[Noise]:
    """Return noises as large as the nominal robot's errors."""
    noises: list[Noise] = []
    for rows in state.objective.data.sources:
        distances = np.linalg.norm(state.errors[rows], axis=1)
        space = float(np.median(distances)) / MEDIAN_OF_CHI_3
        reach = joint_reach(state.linear.by_joints[rows])
        joint = space / reach if joint_noise else 0.0
        noises.append(Noise(max(space, SMALLEST), joint))
    return noises
