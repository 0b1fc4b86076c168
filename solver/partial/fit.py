"""Maximum a posteriori estimate of an arm's unknowns, tool and places, from a few samples.

With y the unknowns, mu and S their prior mean and covariance, widened where something is free, and
e(y) ~ e + G (y - mu) the errors, a step of Gauss-Newton in the space of the samples is

    y = mu - S G^T C^-1 e        C = G S G^T + diag(Sigma_i / w_i)
    Sigma_i = diag(s_t^2 I, s_r^2 I) + s_q^2 J_i J_i^T
    w_i = (nu + d) / (nu + e_i^T Sigma_i^-1 e_i)

for any number of unknowns, those of error curves included. The scales s maximise the evidence
N(e; 0, C) and their own prior.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..bayes.model import Gaussian, student_weights
from ..data import CALIPER_DEVIATION
from ..robot import turn
from .task import NoiseBelief, Task, flanges, linearise

ROUNDS, SETTLED = 40, 0.01
"""Most steps, and the last one's: of samples in deviations of the noise, of scales and weights."""
STEPS = (0.8, 0.93, 1.0, 1.07, 1.25)
"""Factors by which the scales of noise are tried."""


@dataclass(frozen=True)
class State:
    """Unknowns of a task: the arm's and known places' numbers, U's turn, and the places."""

    x: np.ndarray
    tool: np.ndarray
    """U, shape (4, 4)."""
    places: np.ndarray
    """V, shape (K, 4, 4)."""
    noise: NoiseBelief
    weights: np.ndarray
    """Robust weight of each sample, shape (N,)."""
    size: float = 0.0
    """Logarithm of the factor by which measured places are too small."""


@dataclass(frozen=True)
class System:
    """A task, linear about a state: errors of all samples and distances, by all unknowns."""

    task: Task
    state: State
    errors: np.ndarray
    """e at the prior's mean, by the linear model, shape (R,)."""
    slopes: np.ndarray
    """G, shape (R, size)."""
    by_joints: np.ndarray
    """J, shape (N, axes, m)."""

    @cached_property
    def spread(self) -> np.ndarray:
        """G S G^T, shape (R, R)."""
        return self.slopes @ self.task.covariance @ self.slopes.T

    def noise_blocks(self, noise: NoiseBelief) -> np.ndarray:
        """Return Sigma_i of each sample, shape (N, axes, axes)."""
        scales = np.repeat([noise.place, noise.turn], 3)[: self.by_joints.shape[1]]
        of_joints = noise.joint**2 * self.by_joints @ self.by_joints.transpose(0, 2, 1)
        return np.diag(scales**2) + of_joints

    def covariance(self, noise: NoiseBelief, *, gaussian: bool = False) -> np.ndarray:
        """Return C, shape (R, R); ``gaussian``: with Gaussian noise of the same information."""
        return self.spread + self.noise_covariance(noise, gaussian=gaussian)

    def noise_covariance(self, noise: NoiseBelief, *, gaussian: bool = False) -> np.ndarray:
        """Return the same where all unknowns are known, shape (R, R)."""
        N, d, _ = self.by_joints.shape
        blocks = self.noise_blocks(noise) / self.state.weights[:, None, None]
        C = np.diag(np.full(len(self.errors), CALIPER_DEVIATION**2))
        rows = np.arange(N * d, dtype=np.int64).reshape(N, d)
        C[rows[:, :, None], rows[:, None]] = blocks * (1 + 2 * gaussian / (noise.nu + d))
        return C

    def log_evidence(self, noise: NoiseBelief) -> float:
        """Return the logarithm of the evidence and of the scales' prior, but for a constant."""
        belief = self.task.noise
        root = np.linalg.cholesky(self.covariance(noise))
        whitened = np.linalg.solve(root, self.errors)
        log_ratios = np.log([noise.place / belief.place, noise.turn / belief.turn]) / belief.spread
        return float(
            -0.5 * (whitened @ whitened + log_ratios @ log_ratios) - np.log(np.diag(root)).sum()
        )

    @cached_property
    def change(self) -> np.ndarray:
        """The most probable y less mu, shape (size,)."""
        pull = np.linalg.solve(self.covariance(self.state.noise), self.errors)
        return -self.task.covariance @ (self.slopes.T @ pull)

    def posterior_covariance(self, some: np.ndarray | slice) -> np.ndarray:
        """Return the posterior covariance of some unknowns: beside the errors, once these are seen.

        S is large where it has error curves, so its root is that of errors and unknowns alone.
        """
        across = self.slopes @ self.task.covariance[:, some]
        S: np.ndarray = self.task.covariance[some][:, some]
        joint = np.block([[self.spread, across], [across.T, S]])
        count = len(self.errors)
        noise = self.noise_covariance(self.state.noise, gaussian=True)
        whitened = np.linalg.solve(np.linalg.cholesky(noise), np.eye(count, len(joint)))
        prior = Gaussian.of(np.zeros(len(joint)), joint)
        return prior.conditioned(whitened, np.zeros(count)).marginal(slice(count, None)).covariance

    def covariance_on_flange(self, some: np.ndarray) -> np.ndarray:
        """Return the same for an exact chain: how far the flange itself is off is left out."""
        return replace(self, task=self.task.with_exact_arm).posterior_covariance(some)

    @cached_property
    def residuals(self) -> np.ndarray:
        """Errors of the samples at the most probable unknowns, shape (N, axes) [m, rad]."""
        N, d, _ = self.by_joints.shape
        residuals = self.errors + self.slopes @ self.change
        return residuals[: N * d].reshape(N, d)


def fit(task: Task) -> System:
    """Return a task solved: linear about its most probable unknowns."""
    state = _start(task)
    for round_ in range(ROUNDS):
        system = linear(task, state)
        states = _moved(system)
        # while the unknowns are far astray all samples count alike
        weights = _weights(system) if round_ > 1 else state.weights
        state = replace(states, noise=_noise(system), weights=weights)
        change = _step(system, states) / system.state.noise.place
        scales = abs(np.log(state.noise.place / system.state.noise.place))
        reweighted = float(np.abs(state.weights - system.state.weights).max())
        if round_ > 2 and max(change, scales, reweighted) < SETTLED:
            break
    return linear(task, state)


def next_step(system: System) -> float:
    """Return by how much another step would move samples and places [m], [rad]."""
    return _step(system, _moved(system))


def linear(task: Task, state: State) -> System:
    """Return a task, linear about a state."""
    prior, rows = task.prior, task.rows
    poses = flanges(prior, state.x, rows.q, rows.moments)
    e, by_unknowns, by_tool, by_places, by_joints = linearise(
        rows.resized(state.size), poses, prior.ball, state.tool, state.places
    )
    N, d = e.shape
    G = np.zeros((N, d, task.size))
    G[:, :, : prior.model.size] = by_unknowns
    if rows.turns:
        G[:, :, task.tool_turn.start : task.scale.stop] = by_tool
    for i, k in enumerate(rows.places.tolist()):
        G[i][:, task.places[k]] = by_places[i]
    lengths, by_lengths = _distances(task, state)
    slopes = np.vstack([G.reshape(N * d, -1), by_lengths])
    errors = np.concatenate([e.ravel(), lengths])
    # turns, and places nothing is known of, are about where they are
    errors -= slopes[:, : len(prior.mean)] @ (state.x - prior.mean)
    errors -= slopes[:, task.scale].sum(axis=1) * state.size
    return System(task, state, errors, slopes, by_joints)


def _distances(task: Task, state: State) -> tuple[np.ndarray, np.ndarray]:
    slopes = np.zeros((len(task.distances), task.size))
    errors = np.zeros(len(task.distances))
    for row, (a, b, length) in enumerate(task.distances):
        offset = state.places[b, :3, 3] - state.places[a, :3, 3]
        measure = float(np.linalg.norm(offset))
        slopes[row, task.places[b][:3]] = offset / measure
        slopes[row, task.places[a][:3]] = -offset / measure
        errors[row] = measure - length
    return errors, slopes


def _start(task: Task) -> State:
    rows, x, start = task.rows, task.prior.mean, task.start
    tool = np.eye(4) if start is None else start.tool.matrix
    places = np.tile(np.eye(4) if start is None else start.frame.matrix, (len(rows.names), 1, 1))
    state = _placed(task, State(x, tool, places, task.noise, np.ones(len(rows.q))))
    if start is None:
        poses = flanges(task.prior, x, rows.q, rows.moments)
        tips = poses.p + poses.R @ state.tool[:3, 3]
        for k in set(range(len(places))).difference(task.known):
            state.places[k, :3, 3] = np.median(tips[rows.places == k], axis=0)
    return state


def _moved(system: System) -> State:
    """Return the state at the most probable unknowns."""
    task, state, y = system.task, system.state, system.change
    tool, places = state.tool.copy(), state.places.copy()
    size = float(y[task.scale].sum())
    if task.rows.turns:
        tool[:3, :3] = turn(y[task.tool_turn]) @ tool[:3, :3]
    for k, indices in enumerate(task.places):
        places[k, :3, 3] += y[indices[:3]]
        if task.rows.turns:
            places[k, :3, :3] = turn(y[indices[3:]]) @ places[k, :3, :3]
    x = task.prior.mean + y[: len(state.x)]
    return _placed(task, replace(state, x=x, tool=tool, places=places, size=size))


def _placed(task: Task, state: State) -> State:
    """Return the state, U's place and the known places put where the arm's unknowns have them."""
    prior, x, tool, places = task.prior, state.x, state.tool.copy(), state.places.copy()
    tool[:3, 3] = x[prior.ball] + prior.model.ball.nominal[prior.ball]
    for k in task.known:
        places[k, :3, 3] = x[task.places[k]]
    return replace(state, tool=tool, places=places)


def _step(system: System, state: State) -> float:
    """Return by how much samples and places moved in a step [m], [rad]."""
    before = system.state
    chain = system.slopes[:, : len(before.x)] @ (state.x - before.x)
    size = state.size - before.size
    parts = (chain, state.places - before.places, state.tool - before.tool, size)
    return max(float(np.abs(part).max()) for part in parts)


def _noise(system: System) -> NoiseBelief:
    """Return the scales of noise after a step towards more evidence."""
    now = system.state.noise
    turns = STEPS if system.task.rows.turns else (1.0,)
    tried = [replace(now, place=a * now.place, turn=b * now.turn) for a, b in product(STEPS, turns)]
    least = [SMALLEST * scale for scale in (system.task.noise.place, system.task.noise.turn)]
    tried = [noise for noise in tried if noise.place >= least[0] and noise.turn >= least[1]]
    return max(tried, key=system.log_evidence)


def _weights(system: System) -> np.ndarray:
    """Return the robust weights of the samples."""
    e, noise = system.residuals, system.state.noise
    whitened = np.linalg.solve(np.linalg.cholesky(system.noise_blocks(noise)), e[:, :, None])
    return student_weights(np.sum(whitened[:, :, 0] ** 2, axis=1), noise.nu, e.shape[1])


SMALLEST = 1e-2
"""Least noise, as a share of its prior scale: exact data leave none, and no inverse."""
