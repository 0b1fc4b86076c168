"""Maximum a posteriori estimate of an arm's unknowns, tool and places, from a few samples.

With y the unknowns, mu and S their prior mean and covariance, widened where something is free, and
e(y) ~ e + G (y - mu) the errors, a step of Gauss-Newton is

    y = mu - S G^T C^-1 e        C = G S G^T + diag(Sigma_i / w_i)
    Sigma_i = diag(s_t^2 I, s_r^2 I) + s_q^2 J_i J_i^T
    w_i = (nu + d) / (nu + e_i^T Sigma_i^-1 e_i)

for any number of unknowns, those of error curves included. The scales s maximise the evidence
N(e; 0, C) and their own prior. The errors are by how much two ways to a place differ,

    t_i = p(F U L) - p(V R)      r_i = log(rot(F U L) rot(V R)^T)

in the base's axes, and derivatives are by small turns about the axes of flange (U) and base (V).
"""

from dataclasses import replace
from itertools import product

import numpy as np

from ..identification.data import fit_pose
from ..identification.model import student_weights
from ..identification.robot import rotation_vectors, turn
from .prior import Flanges
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


def linear(task: Task, state: State) -> System:
    """Return a task, linear about a state."""
    prior, rows, x = task.prior, task.rows, state.x
    flanges = prior.flanges(x, rows)
    left, right = rows.resized(float(x[task.scale].sum()))
    turns = state.places[rows.places]
    tools = flanges.R @ state.tool
    arms = np.einsum("nij,nj->ni", tools, left[:, :3, 3])
    levers = arms + flanges.R @ prior.tip(x)
    reaches = np.einsum("nij,nj->ni", turns, right[:, :3, 3])
    place_errors = flanges.p + levers - x[task.places[rows.places, :3]] - reaches
    measured = tools @ left[:, :3, :3]
    seen = turns @ right[:, :3, :3]
    turn_errors = rotation_vectors(measured @ seen.swapaxes(1, 2))
    errors = np.hstack([place_errors, turn_errors])[:, : rows.axes]

    G = _slopes(task, flanges, levers, arms, reaches)[:, : rows.axes]
    lengths, by_lengths = _distances(task, x)
    slopes = np.vstack([G.reshape(-1, task.size), by_lengths])
    all_errors = np.concatenate([errors.ravel(), lengths])
    at_mean = all_errors - slopes @ (x - task.mean(x))
    by_joints = _at_end(flanges.by_joints, levers)[:, : rows.axes]
    return System(task, state, at_mean, slopes, by_joints)


def _slopes(
    task: Task,
    flanges: Flanges,
    levers: np.ndarray,
    arms: np.ndarray,
    reaches: np.ndarray,
) -> np.ndarray:
    """Return derivatives of the errors of samples by all unknowns, shape (N, 6, size).

    Args:
        task: The samples and unknowns.
        flanges: The flange's poses, and their derivatives.
        levers: From the flange to the end of U L, shape (N, 3) [m].
        arms: From the tip to the same, shape (N, 3) [m].
        reaches: From the place to the end of V R, shape (N, 3) [m].
    """
    prior, rows, R = task.prior, task.rows, flanges.R
    N = len(R)
    G = np.zeros((N, 6, task.size))
    G[:, :, : prior.model.size] = _at_end(flanges.by_unknowns, levers)
    G[:, :3, prior.ball] = R
    if rows.turns:
        by_turns = np.hstack([0 * R, R])
        G[:, :, task.tool_turn] = _at_end(by_turns, arms)
        G[:, :3, task.scale.start] = arms - reaches
    moved_back = np.tile(-np.eye(6), (N, 1, 1))
    by_place = _at_end(moved_back, reaches)[:, :, : rows.place_axes]
    samples = np.arange(N)[:, None]
    G[samples, :, task.places[rows.places]] = by_place.swapaxes(1, 2)
    return G


def _at_end(slopes: np.ndarray, levers: np.ndarray) -> np.ndarray:
    """Return derivatives of places and turns at the end of levers, shape (N, 6, n).

    A turn w of a lever moves its end by w x lever.

    Args:
        slopes: Those at the beginning, shape (N, 6, n).
        levers: Shape (N, 3) [m].
    """
    moved = slopes.copy()
    moved[:, :3] += np.cross(slopes[:, 3:], levers[:, :, None], axis=1)
    return moved


def _distances(task: Task, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return errors of known distances, shape (D,) [m], and their derivatives, (D, size)."""
    count = len(task.distances)
    slopes = np.zeros((count, task.size))
    errors = np.zeros(count)
    for row, (a, b, distance) in enumerate(task.distances):
        first, second = task.places[[a, b], :3]
        offset = x[second] - x[first]
        length = float(np.linalg.norm(offset))
        direction = offset / length
        slopes[row, second] = direction
        slopes[row, first] = -direction
        errors[row] = length - distance
    return errors, slopes
