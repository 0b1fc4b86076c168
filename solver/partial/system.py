"""Errors of a linear task with their covariance, each sample eliminated alone.

With the slopes G by unknowns of the covariance S, and the noise Sigma, which has a block for each
sample, the errors have the covariance

    C = Sigma + G S G^T = L (1 + W W^T) L^T    Sigma = L L^T    W = L^-1 K    G S G^T = K K^T

so that by Schur's complement c^T C^-1 c = |c' - W z|^2 + |z|^2 and |C| = |Sigma| |1 + W^T W|, where
c' = L^-1 c and z = (1 + W^T W)^-1 W^T c' has the least squares: the time grows with the number of
samples alone. Error curves have more unknowns than there are errors: K is as small as the errors.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..identification.data import CALIPER_DEVIATION, Pose
from ..identification.model import Gaussian
from ..results import rms
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

    @property
    def has_more_unknowns(self) -> bool:
        """True where there are more unknowns than errors, as with error curves."""
        return self.task.size > len(self.errors)

    def noise_blocks(self, noise: NoiseBelief) -> np.ndarray:
        """Return Sigma_i of each sample, shape (N, axes, axes)."""
        J = self.by_joints
        axes = J.shape[1]
        scales = np.repeat([noise.place, noise.turn], 3)[:axes]
        variances = noise.joint**2 + self.task.rows.rounding**2
        of_joints = variances * J @ J.swapaxes(1, 2)
        return np.diag(scales**2) + of_joints

    def weighted_blocks(self, noise: NoiseBelief) -> np.ndarray:
        """Return Sigma_i / w_i, shape (N, axes, axes)."""
        return self.noise_blocks(noise) / self.state.weights[:, None, None]

    @property
    def with_gaussian_noise(self) -> "System":
        """The same with Gaussian noise that has the same information."""
        factor = 1 + 2 / (self.state.noise.nu + self.by_joints.shape[1])
        state = replace(self.state, weights=self.state.weights / factor)
        return replace(self, state=state)

    def in_noise(
        self, columns: np.ndarray, noise: NoiseBelief
    ) -> tuple[np.ndarray, float]:
        """Return columns (R, n) in units of the noise, and ln |Sigma| / 2."""
        N, axes, _ = self.by_joints.shape
        blocks = self.weighted_blocks(noise)
        roots = np.linalg.cholesky(blocks)
        of_samples = columns[: N * axes].reshape(N, axes, -1)
        white = (np.linalg.inv(roots) @ of_samples).reshape(N * axes, -1)
        lengths = columns[N * axes :] / CALIPER_DEVIATION
        log_volume = np.log(np.diagonal(roots, axis1=1, axis2=2)).sum()
        log_volume += len(lengths) * np.log(CALIPER_DEVIATION)
        return np.concatenate([white, lengths]), float(log_volume)

    def whitened(
        self, columns: np.ndarray, noise: NoiseBelief
    ) -> tuple[np.ndarray, float]:
        """Return X, with X^T X = c^T C^-1 c of columns c, shape (R + r, n); and ln |C| / 2."""
        count = self._root.shape[1]
        both = np.column_stack([self._root, columns])
        white, log_volume = self.in_noise(both, noise)
        W, c = white[:, :count], white[:, count:]
        H = np.eye(count) + W.T @ W
        z, root = np.linalg.solve(H, W.T @ c), np.linalg.cholesky(H)
        log_volume += float(np.log(np.diag(root)).sum())
        return np.concatenate([c - W @ z, z]), log_volume

    def log_evidence(self, noise: NoiseBelief | None = None) -> float:
        """Return the logarithm of the evidence and of the scales' prior, but for a constant.

        By the state's noise, or by another.
        """
        noise = noise or self.state.noise
        belief = self.task.noise
        ratios = [noise.place / belief.place, noise.turn / belief.turn]
        scales = np.log(ratios) / belief.spread
        white, log_volume = self.whitened(self.errors[:, None], noise)
        return -0.5 * float(np.sum(white**2) + scales @ scales) - log_volume

    @cached_property
    def _root(self) -> np.ndarray:
        """K with G S G^T = K K^T, by independent unknowns of unit deviation, shape (R, r)."""
        if self.has_more_unknowns:
            return Gaussian.of(self.errors, self._spread).root
        return self.slopes @ self.task.independent.root

    @cached_property
    def _spread(self) -> np.ndarray:
        """G S G^T, shape (R, R); a sample has few of the unknowns of error curves."""
        S, axes = self.task.covariance, self.by_joints.shape[1]
        parts = np.split(self.slopes, range(axes, len(self.slopes), axes))
        columns = [np.flatnonzero(part.any(axis=0)) for part in parts]
        pairs = [*zip(parts, columns, strict=True)]
        GS = np.concatenate([part[:, some] @ S[some] for part, some in pairs])
        return np.hstack([GS[:, some] @ part[:, some].T for part, some in pairs])

    @cached_property
    def change(self) -> np.ndarray:
        """The most probable y less mu, shape (size,)."""
        columns, noise = np.column_stack([self.errors, self.slopes]), self.state.noise
        if not self.has_more_unknowns:
            white, _ = self.in_noise(columns, noise)
            return self.task.independent.conditioned(white[:, 1:], white[:, 0]).mean
        X, _ = self.whitened(columns, noise)
        return -self.task.covariance @ (X[:, 1:].T @ X[:, 0])

    def _seen(
        self, some: np.ndarray | slice
    ) -> tuple[Gaussian, np.ndarray, np.ndarray | slice]:
        """Return a Gaussian that the errors were seen of, its slopes to them, and where some are.

        Its unknowns are all; of error curves, which are more than there are errors, these errors
        and some unknowns.
        """
        count = len(self.errors)
        if self.has_more_unknowns:
            S = self.task.covariance[some]
            across = self.slopes @ S.T
            of_both = np.block([[self._spread, across], [across.T, S[:, some]]])
            prior = Gaussian.of(np.zeros(len(of_both)), of_both)
            slopes, rows = np.eye(count, len(of_both)), slice(count, None)
        else:
            prior, slopes, rows = self.task.independent, self.slopes, some
        white, _ = self.in_noise(slopes, self.state.noise)
        return prior.conditioned(white, np.zeros(count)), slopes, rows

    def posterior_covariance(self, some: np.ndarray | slice) -> np.ndarray:
        """Return the posterior covariance of some unknowns."""
        posterior, _, rows = self.with_gaussian_noise._seen(some)
        return posterior.marginal(rows).covariance

    def held_out(self) -> np.ndarray:
        """Return the error of each sample as all others predict it, shape (N, axes) [m, rad].

        With the residuals r and their posterior covariance Q_i, less noise, that is
        (1 - Q_i Sigma_i^-1)^-1 r_i.
        """
        N, axes, _ = self.by_joints.shape
        posterior, slopes, _ = self._seen(slice(0))
        of_samples = slopes[: N * axes]
        root = (of_samples @ posterior.root).reshape(N, axes, -1)
        Q = root @ root.swapaxes(1, 2)
        blocks = self.weighted_blocks(self.state.noise)
        shares = np.linalg.solve(blocks - Q, self.residuals[:, :, None])
        return (blocks @ shares)[:, :, 0]

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
        return rms(self.residuals)

    def outliers(self, noun: str) -> dict[int, str]:
        """Return the outliers among the samples, and where each stands, or its number."""
        wheres = self.task.rows.wheres.tolist()
        indices = np.flatnonzero(self.state.weights < OUTLIER).tolist()
        return {i: wheres[i] or f"{noun} {i}" for i in indices}
