"""The states of the estimation: the first one, and that after a step of all unknowns."""

from dataclasses import dataclass, replace

import numpy as np

from ..model import ExtendedModel, Noise, PriorGroup, prior_groups
from .arrowhead import Inverse
from .normal_equations import NormalEquations
from .objective import Objective, State, linearise, predict_balls, to_world
from .posterior import JointPosterior, Posterior


@dataclass(frozen=True)
class Step:
    """A Gauss-Newton step, and what it was computed from."""

    change: np.ndarray
    """Of all unknowns, shape (n,); zero for those that are held."""
    covariance: Inverse
    """Inverse of the whole curvature, priors included; zero for what is held."""
    normal: NormalEquations
    leverage: np.ndarray
    """L_i of (A5), shape (N, 3, 3) [m^2]."""
    volume: float
    """Factor of the volume's slope; 1 where the noise fits the errors."""
    slope: float
    """Slope of L along the change, per whole step."""


def start(objective: Objective, joint_noise: bool, near: JointPosterior | None = None) -> State:
    """Return the first state: nominal robots, each socket at the median of its balls."""
    rows, model = objective.rows, objective.model
    x, at_zero = np.zeros(model.size), np.zeros(model.size, dtype=bool)
    groups: list[PriorGroup] = []
    for i, (own, one, arm) in enumerate(zip(model.own, model.models, rows.scene.arms, strict=True)):
        mine = prior_groups(one, arm)
        for group in mine:
            if group.name in ("ball", "given"):  # known to be anywhere, far from nominal
                x[own.start + group.members] = group.mean
        if near is not None:
            x[own], at_zero[own], mine = _carried_over(one, mine, near.arms[i])
        groups += [replace(g, members=g.members + own.start) for g in mine]
    begin = model.own[-1].stop
    for one in model.movements:
        groups.append(one.prior(begin))
        begin += one.size
    balls = predict_balls(objective, x)
    points = balls[0]
    frames = rows.place_frames(points)
    in_world = to_world(objective, frames, points)
    centres = np.array(
        [np.median(in_world[rows.sockets == k], axis=0) for k in range(rows.socket_count)]
    ).reshape(-1, 3)
    linear = linearise(objective, x, centres, frames, balls)
    noises = list[Noise]() if near is None else [*near.noises_of(rows)]
    for source in rows.sources if near is None else ():  # as large as the nominal robot's errors
        typical = float(np.median(np.linalg.norm(linear.errors[source], axis=1))) / 1.54
        squares: np.ndarray = np.sum(linear.by_joints[source] ** 2, axis=(1, 2)) / 3
        joint = typical / float(np.mean(squares)) ** 0.5 if joint_noise else 0.0
        noises.append(Noise(max(typical, 1e-7), joint))
    return State(x, centres, frames, tuple(groups), tuple(noises), at_zero, linear)


def _carried_over(
    model: ExtendedModel, groups: tuple[PriorGroup, ...], near: Posterior
) -> tuple[np.ndarray, np.ndarray, tuple[PriorGroup, ...]]:
    """Return unknowns, which of them are held at zero, and priors, as far as a result has them."""
    there = {name: i for i, name in enumerate(near.model.names)}
    common = [i for i, name in enumerate(model.names) if name in there]
    x, at_zero = np.zeros(model.size), np.zeros(model.size, dtype=bool)
    x[common] = near.x[[there[model.names[i]] for i in common]]
    at_zero[common] = x[common] == 0
    fitted = {group.name: group for group in near.groups}
    return (
        x,
        at_zero,
        tuple(
            replace(fitted[group.name], members=group.members, trail=None)
            if group.name in fitted and fitted[group.name].expected is group.expected
            else group
            for group in groups
        ),
    )


def moved(objective: Objective, state: State, change: np.ndarray) -> State:
    """Return the state after a change of all unknowns, sockets going along with their balls.

    Left on the tangent, a centre would be a reason not to turn the whole robot.
    """
    size, dense = objective.model.size, objective.dense
    x, turns = state.x + change[:size], change[size:dense].reshape(-1, 6)
    frames = tuple(pose.moved(turn) for pose, turn in zip(state.frames, turns, strict=True))
    balls, rows = predict_balls(objective, x), objective.rows
    centres = state.centres + change[dense:].reshape(-1, 3)
    seated = rows.seated
    tangent = (state.linear.errors + state.linear.by_unknowns @ change[:dense])[seated]
    tangent += state.centres[rows.sockets[seated]]
    off = np.zeros((len(rows.sockets), 3))
    there = to_world(objective, frames, balls[0]) - objective.moved_places(x)
    off[seated] = there[seated] - tangent
    along = rows.by_socket(off) / np.bincount(rows.sockets[seated])[:, None]
    along[[one.socket for one in rows.located]] = 0.0
    centres += along
    linear = linearise(objective, x, centres, frames, balls)
    return replace(state, x=x, centres=centres, frames=frames, linear=linear)
