"""Maximum a posteriori estimate of an arm's unknowns, tool and places, from a few samples.

With y the unknowns, mu and S their prior mean and covariance, widened where something is free, and
e(y) ~ e + G (y - mu) the errors, a step of Gauss-Newton is

    y = mu - S G^T C^-1 e        C = G S G^T + diag(Sigma_i / w_i)
    Sigma_i = diag(s_t^2 I, s_r^2 I) + s_q^2 J_i J_i^T
    w_i = (nu + d) / (nu + e_i^T Sigma_i^-1 e_i)

for any number of unknowns, those of error curves included. The scales s maximise the evidence
N(e; 0, C) and their own prior.
"""

from dataclasses import replace
from itertools import product

import numpy as np

from ..identification.data import fit_pose
from ..identification.model import student_weights
from ..identification.robot import turn
from .linear import linear
from .system import System
from .task import NoiseBelief, State, Task

ROUNDS, SETTLED = 40, 0.01
"""Most steps, and the last one's: of samples in deviations of the noise, of scales and weights."""
STEPS = (0.8, 0.93, 1.0, 1.07, 1.25)
"""Factors by which the scales of noise are tried."""
SMALLEST = 1e-2
"""Least noise, as a share of its prior scale: exact data leave none, and no inverse."""


def fit(task: Task) -> System:
    """Return a task solved: linear about its most probable unknowns."""
    state = _start(task)
    for round_ in range(ROUNDS):
        system = linear(task, state)
        # while the unknowns are far astray all samples count alike
        weights = _weights(system) if round_ > 1 else state.weights
        state = replace(_moved(system), noise=_noise(system), weights=weights)
        before = system.state
        changes = [
            _step(system, state) / before.noise.place,
            abs(np.log(state.noise.place / before.noise.place)),
            np.abs(state.weights - before.weights).max(),
        ]
        if round_ > 2 and max(changes) < SETTLED:
            break
    return linear(task, state)


def next_step(system: System) -> float:
    """Return by how much another step would move samples and places [m], [rad]."""
    return _step(system, _moved(system))


def _start(task: Task) -> State:
    """Return the state before the first step."""
    rows, prior, start = task.rows, task.prior, task.start
    x = np.zeros(task.size)
    x[: len(prior.mean)] = prior.mean
    count = len(rows.names)
    new = [k for k in range(count) if k not in task.known]
    tool = np.eye(3)
    places = np.tile(tool, (count, 1, 1))
    if start is None:
        flanges = prior.flanges(x, rows)
        tips = flanges.p + flanges.R @ prior.tip(x)
        for k in new:
            here = rows.places == k
            x[task.places[k, :3]] = np.median(tips[here], axis=0)
            if rows.framed:
                frame = fit_pose(rows.right[here, :3, 3], tips[here])
                x[task.places[k, :3]], places[k] = frame.translation, frame.rotation
    else:
        tool, places = start.tool.rotation, places @ start.frame.rotation
        x[task.places[new, :3]] = start.frame.translation
    weights = np.ones(len(rows.q))
    return State(x, tool, places, task.noise, weights)


def _moved(system: System) -> State:
    """Return the state at the most probable unknowns."""
    task, state = system.task, system.state
    x = task.mean(state.x) + system.change
    turns = task.places[:, 3:]
    if not turns.size:
        return replace(state, x=x)
    tool = state.tool
    if task.rows.turns:
        tool = turn(x[task.tool_turn]) @ tool
    places = turn(x[turns]) @ state.places
    x[task.tool_turn] = x[turns] = 0.0
    return replace(state, x=x, tool=tool, places=places)


def _step(system: System, state: State) -> float:
    """Return by how much samples and places moved in a step [m], [rad]."""
    task, before = system.task, system.state
    moved = state.x - before.x
    of_arm = slice(len(task.prior.mean))
    places = np.concatenate([task.prior.ball, task.places[:, :3].ravel()])
    steps = [
        system.slopes[:, of_arm] @ moved[of_arm],
        moved[places],
        moved[task.scale],
        np.ravel(state.tool - before.tool),
        np.ravel(state.places - before.places),
    ]
    return float(np.abs(np.concatenate(steps)).max())


def _noise(system: System) -> NoiseBelief:
    """Return the scales of noise after a step towards more evidence."""
    now, belief = system.state.noise, system.task.noise
    turns = STEPS if system.task.rows.turns else (1.0,)
    scaled = [
        replace(now, place=a * now.place, turn=b * now.turn)
        for a, b in product(STEPS, turns)
    ]
    candidates = [
        noise
        for noise in scaled
        if noise.place >= SMALLEST * belief.place
        and noise.turn >= SMALLEST * belief.turn
    ]
    return max(candidates, key=system.log_evidence)


def _weights(system: System) -> np.ndarray:
    """Return the robust weights of the samples."""
    e, noise = system.residuals, system.state.noise
    roots = np.linalg.cholesky(system.noise_blocks(noise))
    whitened = np.linalg.solve(roots, e[:, :, None])[:, :, 0]
    squares = np.sum(whitened**2, axis=1)
    return student_weights(squares, noise.nu, e.shape[1])
