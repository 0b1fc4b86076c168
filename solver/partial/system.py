"""A task made linear: errors of its samples, their derivatives by all unknowns, their covariance.

The two ways to a place differ by

    t_i = p(F U L) - p(V R)      r_i = log(rot(F U L) rot(V R)^T)

in the base's axes, and derivatives are by small turns about the axes of flange (U) and base (V).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..identification.data import CALIPER_DEVIATION, Pose
from ..identification.model import Gaussian
from ..identification.robot import rotation_vectors
from .prior import Flanges
from .task import NoiseBelief, State, Task

OUTLIER = 0.25
"""Robust weight below which a sample is an outlier: an error of six standard deviations."""


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

    @property
    def shift(self) -> np.ndarray:
        """Change of the arm's unknowns from their prior mean, shape (n,)."""
        mean = self.task.prior.mean
        return self.state.x[: len(mean)] - mean

    @property
    def tool(self) -> Pose:
        """U, on the flange."""
        return Pose(self.state.tool, self.task.prior.tip(self.state.x))

    @property
    def place(self) -> Pose:
        """V of the first place, in the base."""
        return Pose(self.state.places[0], self.state.x[self.task.places[0, :3]])

    @property
    def size(self) -> float:
        """Logarithm of the factor by which measured places are too small."""
        return float(self.state.x[self.task.scale].sum())

    @cached_property
    def spread(self) -> np.ndarray:
        """G S G^T, shape (R, R)."""
        return self.slopes @ self.task.covariance @ self.slopes.T

    def noise_blocks(self, noise: NoiseBelief) -> np.ndarray:
        """Return Sigma_i of each sample, shape (N, axes, axes)."""
        J = self.by_joints
        axes = J.shape[1]
        scales = np.repeat([noise.place, noise.turn], 3)[:axes]
        variances = noise.joint**2 + self.task.rows.rounding**2
        of_joints = variances * J @ J.transpose(0, 2, 1)
        return np.diag(scales**2) + of_joints

    def covariance(self, noise: NoiseBelief, *, gaussian: bool = False) -> np.ndarray:
        """Return C, shape (R, R); ``gaussian``: with Gaussian noise of the same information."""
        return self.spread + self.noise_covariance(noise, gaussian=gaussian)

    def noise_covariance(self, noise: NoiseBelief, *, gaussian: bool) -> np.ndarray:
        """Return the same where all unknowns are known, shape (R, R)."""
        N, axes, _ = self.by_joints.shape
        blocks = self.noise_blocks(noise) / self.state.weights[:, None, None]
        if gaussian:
            blocks = blocks * (1 + 2 / (noise.nu + axes))
        C = CALIPER_DEVIATION**2 * np.eye(len(self.errors))
        rows = np.arange(N * axes, dtype=np.int64).reshape(N, axes)
        C[rows[:, :, None], rows[:, None]] = blocks
        return C

    def log_evidence(self, noise: NoiseBelief | None = None) -> float:
        """Return the logarithm of the evidence and of the scales' prior, but for a constant.

        By the state's noise, or by another.
        """
        noise = noise or self.state.noise
        belief = self.task.noise
        ratios = [noise.place / belief.place, noise.turn / belief.turn]
        scales = np.log(ratios) / belief.spread
        white, log_volume = self._whitened(noise)
        of_errors, of_roots = white[:, 0], white[:, 1:]
        root = np.linalg.cholesky(np.eye(of_roots.shape[1]) + of_roots.T @ of_roots)
        explained = np.linalg.solve(root, of_roots.T @ of_errors)
        squares = of_errors @ of_errors - explained @ explained + scales @ scales
        return float(-0.5 * squares - log_volume - np.log(np.diag(root)).sum())

    @cached_property
    def _by_independent(self) -> np.ndarray:
        """G F with S = F F^T, shape (R, size): slopes by independent unknowns of unit deviation."""
        values, axes = np.linalg.eigh(self.task.covariance)
        return self.slopes @ (axes * np.sqrt(values.clip(0)))

    def _whitened(self, noise: NoiseBelief) -> tuple[np.ndarray, float]:
        """Return e and G F in units of the noise, shape (R, 1 + size); and ln |Sigma| / 2.

        Sigma has a block for each sample, so that the time grows with their number alone.
        """
        N, axes, _ = self.by_joints.shape
        columns = np.column_stack([self.errors, self._by_independent])
        blocks = self.noise_blocks(noise) / self.state.weights[:, None, None]
        roots = np.linalg.cholesky(blocks)
        of_samples = columns[: N * axes].reshape(N, axes, -1)
        white = np.linalg.solve(roots, of_samples).reshape(N * axes, -1)
        lengths = columns[N * axes :] / CALIPER_DEVIATION
        log_volume = np.log(np.diagonal(roots, axis1=1, axis2=2)).sum()
        log_volume += len(lengths) * np.log(CALIPER_DEVIATION)
        return np.concatenate([white, lengths]), float(log_volume)

    @cached_property
    def change(self) -> np.ndarray:
        """The most probable y less mu, shape (size,)."""
        pull = np.linalg.solve(self.covariance(self.state.noise), self.errors)
        return -self.task.covariance @ (self.slopes.T @ pull)

    def posterior_covariance(self, some: np.ndarray | slice) -> np.ndarray:
        """Return the posterior covariance of some unknowns: beside the errors, once these are seen.

        S is large where it has error curves, so its root is that of errors and unknowns alone.
        """
        S = self.task.covariance[some]
        across = self.slopes @ S.T
        of_both = np.block([[self.spread, across], [across.T, S[:, some]]])
        prior = Gaussian.of(np.zeros(len(of_both)), of_both)
        count = len(self.errors)
        root = np.linalg.cholesky(
            self.noise_covariance(self.state.noise, gaussian=True)
        )
        whitened = np.linalg.solve(root, np.eye(count, len(of_both)))
        unknowns = slice(count, None)
        return (
            prior.conditioned(whitened, np.zeros(count)).marginal(unknowns).covariance
        )

    def covariance_on_flange(self, some: np.ndarray) -> np.ndarray:
        """Return the same for an exact chain: how far the flange itself is off is left out."""
        return replace(self, task=self.task.with_exact_arm).posterior_covariance(some)

    @cached_property
    def residuals(self) -> np.ndarray:
        """Errors of the samples at the most probable unknowns, shape (N, axes) [m, rad]."""
        N, axes, _ = self.by_joints.shape
        residuals = self.errors + self.slopes @ self.change
        return residuals[: N * axes].reshape(N, axes)

    @property
    def rms_error(self) -> float:
        """Root mean square of the residuals, axis by axis [m]."""
        return float(np.sqrt(np.mean(self.residuals**2)))

    def outliers(self, noun: str) -> dict[int, str]:
        """Return the outliers among the samples, and where each stands, or its number."""
        wheres = self.task.rows.wheres.tolist()
        indices = np.flatnonzero(self.state.weights < OUTLIER).tolist()
        return {i: wheres[i] or f"{noun} {i}" for i in indices}


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
    turn_errors = rotation_vectors(measured @ seen.transpose(0, 2, 1))
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
    by_place = _at_end(moved_back, reaches)[:, :, : rows.axes]
    samples = np.arange(N)[:, None]
    G[samples, :, task.places[rows.places]] = by_place.transpose(0, 2, 1)
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
