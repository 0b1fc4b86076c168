"""Maximum a posteriori estimate of an arm's unknowns, tool and places, from a few samples.

With y the unknowns, mu and S their prior mean and covariance, widened where something is free, and
e(y) ~ e + G (y - mu) the errors, a step of Gauss-Newton in the space of the samples is

    y = mu - S G^T C^-1 e        C = G S G^T + diag(Sigma_i / w_i)
    Sigma_i = diag(s_t^2 I, s_r^2 I) + s_q^2 J_i J_i^T
    w_i = (nu + d) / (nu + e_i^T Sigma_i^-1 e_i)

for any number of unknowns, those of error curves included. The scales s maximise the evidence
N(e; 0, C) and their own prior.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from ..bayes.model import NU
from ..data import CALIPER_DEVIATION, turn
from .prior import ArmPrior
from .rows import Rows, flanges, linearise

FAR, ANY_TURN = 1.0, 3.0
"""Standard deviations of what is not known at all [m], [rad]."""
ROUNDS, SETTLED = 40, 0.01
"""Most steps, and the last one's: of samples in deviations of the noise, of scales and weights."""
STEPS = (0.8, 0.93, 1.0, 1.07, 1.25)
"""Factors by which the scales of noise are tried."""


@dataclass(frozen=True)
class NoiseBelief:
    """What is believed of the noise before the samples."""

    place: float
    """s_t, of a place [m]."""
    turn: float = 1e-3
    """s_r, of a turn [rad]."""
    joint: float = 0.0
    """s_q, of the joints' angles [rad]; as the calibration found it."""
    nu: float = NU
    """How heavy the errors' tails are; as the calibration found it."""
    spread: float = 0.3
    """Standard deviation of the logarithms of s_t and s_r."""


@dataclass(frozen=True)
class Task:
    """What is fitted: an arm's prior, samples, and what is free."""

    prior: ArmPrior
    rows: Rows
    noise: NoiseBelief
    free: Mapping[int, float] = field(default_factory=dict[int, float])
    """Standard deviations by which the prior of some unknowns is widened."""
    distances: Sequence[tuple[int, int, float]] = ()
    """Known distances: two places, and how far they are apart [m]."""
    tool: np.ndarray = field(default_factory=lambda: np.eye(4))
    """Where U begins; its place is among the arm's unknowns."""
    start: np.ndarray | None = None
    """Where the places begin, shape (K, 4, 4); None for where the samples' tools are."""
    warnings: tuple[str, ...] = ()
    """Remarks on the samples."""

    @cached_property
    def known(self) -> dict[int, int]:
        """Places that stand where the calibration saw them, and which unknowns they are."""
        names = enumerate(self.rows.names)
        return {k: self.prior.sockets[name] for k, name in names if name in self.prior.sockets}

    @cached_property
    def tool_turn(self) -> slice:
        """Which unknowns turn U."""
        n = len(self.prior.mean)
        return slice(n, n + (3 if self.rows.turns else 0))

    def place(self, k: int) -> np.ndarray:
        """Return which unknowns are a place's."""
        if k in self.known:
            return self.known[k] + np.arange(3)
        new = [i for i in range(len(self.rows.names)) if i not in self.known]
        begin = self.tool_turn.stop + self.rows.axes * new.index(k)
        return begin + np.arange(self.rows.axes)

    @cached_property
    def size(self) -> int:
        """Number of all unknowns."""
        new = len(self.rows.names) - len(self.known)
        return self.tool_turn.stop + self.rows.axes * new

    @cached_property
    def covariance(self) -> np.ndarray:
        """S, shape (size, size)."""
        n, axes = len(self.prior.mean), self.rows.axes
        wide = np.full(self.size, FAR)
        wide[self.tool_turn] = ANY_TURN
        for k in range(len(self.rows.names)):
            if k not in self.known and axes == 6:
                wide[self.place(k)[3:]] = ANY_TURN
        S = np.diag(wide**2)
        S[:n, :n] = self.prior.covariance
        for i, width in self.free.items():
            S[i, i] += width**2
        return S


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
    spread: np.ndarray
    """G S G^T, shape (R, R)."""

    def scatter(self, noise: NoiseBelief, *, told: bool = False) -> np.ndarray:
        """Return the noise's covariance, shape (R, R); told: Gaussian noise that tells as much."""
        N, d, _ = self.by_joints.shape
        own = np.repeat([noise.place, noise.turn], 3)[:d] ** 2
        blocks = noise.joint**2 * self.by_joints @ self.by_joints.transpose(0, 2, 1)
        blocks = (blocks + np.diag(own)) / self.state.weights[:, None, None]
        C = np.diag(np.full(len(self.errors), CALIPER_DEVIATION**2))
        own_rows = np.arange(N * d, dtype=np.int64).reshape(N, d)
        C[own_rows[:, :, None], own_rows[:, None]] = blocks * (1 + 2 * told / (noise.nu + d))
        return C

    def log_evidence(self, noise: NoiseBelief, belief: NoiseBelief) -> float:
        """Return the logarithm of the evidence and of the scales' prior, but for a constant."""
        C = self.spread + self.scatter(noise)
        root = np.linalg.cholesky(C)
        left = np.linalg.solve(root, self.errors)
        off = np.log([noise.place / belief.place, noise.turn / belief.turn]) / belief.spread
        return float(-0.5 * (left @ left + off @ off) - np.log(np.diag(root)).sum())

    def solved(self) -> np.ndarray:
        """Return the most probable y less mu, shape (size,)."""
        C = self.spread + self.scatter(self.state.noise)
        return -self.task.covariance @ (self.slopes.T @ np.linalg.solve(C, self.errors))

    def posterior_covariance(self, some: np.ndarray | slice) -> np.ndarray:
        """Return the posterior covariance of some unknowns."""
        C = self.spread + self.scatter(self.state.noise, told=True)
        across = self.slopes @ self.task.covariance[:, some]
        S: np.ndarray = self.task.covariance[some][:, some]
        found = S - across.T @ np.linalg.solve(C, across)
        return (found + found.T) / 2

    def covariance_on_flange(self, some: np.ndarray) -> np.ndarray:
        """Return the same for the arm as it came out: how far the flange itself is off is left."""
        prior = self.task.prior
        held = replace(self.task, prior=replace(prior, covariance=0 * prior.covariance))
        return linear(held, self.state).posterior_covariance(some)

    @cached_property
    def residuals(self) -> np.ndarray:
        """Errors of the samples at the most probable unknowns, shape (N, axes) [m, rad]."""
        N, d, _ = self.by_joints.shape
        left = self.errors + self.slopes @ self.solved()
        return left[: N * d].reshape(N, d)


def fit(task: Task) -> System:
    """Return a task solved: linear about its most probable unknowns."""
    state = _start(task)
    for round_ in range(ROUNDS):
        system = linear(task, state)
        moved = _moved(system)
        state = replace(moved, noise=_noise(system), weights=_weights(system, round_ > 1))
        change = _change(system, moved) / system.state.noise.place
        scales = abs(np.log(state.noise.place / system.state.noise.place))
        weights = float(np.abs(state.weights - system.state.weights).max())
        if round_ > 2 and max(change, scales, weights) < SETTLED:
            break
    return linear(task, state)


def next_step(system: System) -> float:
    """Return by how much another step would move samples and places [m], [rad]."""
    return _change(system, _moved(system))


def linear(task: Task, state: State) -> System:
    """Return a task, linear about a state."""
    prior, rows = task.prior, task.rows
    x, n = state.x[: prior.model.size], prior.model.size
    at = flanges(prior.model, prior.ball, x, rows.q, rows.moments)
    e, by_unknowns, by_tool, by_places, by_joints = linearise(
        rows, at, prior.ball, state.tool, state.places
    )
    N, d = e.shape
    G = np.zeros((N, d, task.size))
    G[:, :, :n] = by_unknowns
    G[:, :, task.tool_turn] = by_tool[:, :, : 3 if rows.turns else 0]
    for i, k in enumerate(rows.places.tolist()):
        G[i][:, task.place(k)] = by_places[i]
    lengths, by_lengths = _distances(task, state)
    slopes = np.vstack([G.reshape(N * d, -1), by_lengths])
    errors = np.concatenate([e.ravel(), lengths])
    # turns, and places nothing is known of, are about where they are
    errors -= slopes[:, : len(prior.mean)] @ (state.x - prior.mean)
    spread = slopes @ task.covariance @ slopes.T
    return System(task, state, errors, slopes, by_joints, spread)


def _distances(task: Task, state: State) -> tuple[np.ndarray, np.ndarray]:
    slopes = np.zeros((len(task.distances), task.size))
    errors = np.zeros(len(task.distances))
    for row, (a, b, length) in enumerate(task.distances):
        away = state.places[b, :3, 3] - state.places[a, :3, 3]
        found = float(np.linalg.norm(away))
        slopes[row, task.place(b)[:3]], slopes[row, task.place(a)[:3]] = away / found, -away / found
        errors[row] = found - length
    return errors, slopes


def _start(task: Task) -> State:
    prior, rows = task.prior, task.rows
    tool, x = task.tool.copy(), prior.mean.copy()
    tool[:3, 3] = x[prior.ball] + prior.model.ball.nominal[prior.ball]
    at = flanges(prior.model, prior.ball, x[: prior.model.size], rows.q, rows.moments)
    if task.start is None:
        tips = at.p + at.R @ tool[:3, 3]
        places = np.tile(np.eye(4), (len(rows.names), 1, 1))
        for k in range(len(rows.names)):
            places[k, :3, 3] = np.median(tips[rows.places == k], axis=0)
    else:
        places = task.start.copy()
    for k, begin in task.known.items():
        places[k, :3, 3] = x[begin : begin + 3]
    return State(x, tool, places, task.noise, np.ones(len(rows.q)))


def _moved(system: System) -> State:
    """Return the state at the most probable unknowns."""
    task, state, y = system.task, system.state, system.solved()
    n = len(task.prior.mean)
    x, tool, places = task.prior.mean + y[:n], state.tool.copy(), state.places.copy()
    tool[:3, 3] = x[task.prior.ball] + task.prior.model.ball.nominal[task.prior.ball]
    if task.rows.turns:
        tool[:3, :3] = turn(y[task.tool_turn]) @ tool[:3, :3]
    for k in range(len(places)):
        own = task.place(k)
        if k in task.known:
            places[k, :3, 3] = x[own]
            continue
        places[k, :3, 3] += y[own[:3]]
        if task.rows.turns:
            places[k, :3, :3] = turn(y[own[3:]]) @ places[k, :3, :3]
    return replace(state, x=x, tool=tool, places=places)


def _change(system: System, moved: State) -> float:
    """Return by how much samples and places moved in a step [m], [rad]."""
    before = system.state
    chain = system.slopes[:, : len(before.x)] @ (moved.x - before.x)
    parts = (chain, moved.places - before.places, moved.tool - before.tool)
    return max(float(np.abs(part).max()) for part in parts)


def _noise(system: System) -> NoiseBelief:
    """Return the scales of noise after a step towards more evidence."""
    now, belief = system.state.noise, system.task.noise
    turns = STEPS if system.task.rows.turns else (1.0,)
    tried = [replace(now, place=a * now.place, turn=b * now.turn) for a, b in product(STEPS, turns)]
    return max(tried, key=lambda one: system.log_evidence(one, belief))


def _weights(system: System, robust: bool) -> np.ndarray:
    """Return the robust weights of the samples; all 1 while the unknowns are far astray."""
    (N, d, _), nu = system.by_joints.shape, system.state.noise.nu
    if not robust:
        return np.ones(len(system.by_joints))
    even = replace(system, state=replace(system.state, weights=np.ones(N)))
    C, e = even.scatter(system.state.noise)[: N * d, : N * d], system.residuals
    whitened: np.ndarray = np.linalg.solve(np.linalg.cholesky(C), e.ravel())
    squares: np.ndarray = np.sum(whitened.reshape(N, d) ** 2, axis=1)
    return (nu + d) / (nu + squares)
