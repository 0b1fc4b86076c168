"""The posterior covariance of arms whose gears have play, which moves samples alike."""

from typing import NamedTuple

import numpy as np

from ..inference import Posterior
from ..model import Gaussian, probabilities
from .projections import evenly

LENGTHS = (0.3, 0.6, 1.2, 2.4)
"""In joint space, over which errors are alike [rad]."""
SHARES = np.linspace(0, 0.9, 10)[:, None]
"""Of the errors' variance that is alike."""
MOST, DECIDED = 150, 1e-3
"""Samples that tell of it at most; and variance below which a fit leaves nothing of an error."""


class WhitenedSamples(NamedTuple):
    """N samples in sockets, their noise made one."""

    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    residuals: np.ndarray
    """Shape (N, 3)."""
    slopes: np.ndarray
    """A: derivatives of the residuals by the model's unknowns and the centres, shape (N, 3, n)."""


def _whitened_samples(posterior: Posterior) -> WhitenedSamples:
    """Return the samples, with L^-1 before residuals and derivatives where L L^T is their noise."""
    data = posterior.data
    rows = np.flatnonzero(data.sockets >= 0)
    sockets = data.sockets[rows]
    q = data.positions[rows]
    points, J, by_joints = posterior.linearise(q, data.torques[rows], data.clocks[rows])
    by_centres = -np.kron(np.eye(len(posterior.centres))[sockets], np.eye(3))
    residuals = points - posterior.centres[sockets]
    columns = np.dstack([residuals, J, by_centres.reshape(*residuals.shape, -1)])
    L = np.linalg.cholesky(posterior.noise.as_gaussian(by_joints))
    white = np.linalg.solve(L, columns)
    return WhitenedSamples(q, white[:, :, 0], white[:, :, 1:])


def with_correlated_errors(posterior: Posterior) -> np.ndarray:
    """Return the covariance of the model's unknowns where play moves samples alike (A11).

    With P = R R^T and W = A R, it is the sum over axes and lengths l in

        R (1 - rho W^T W + rho W^T K W) R^T,    K_ij = exp(-|q_i - q_j|^2 / 2 l^2)

    P is wider than the samples alone would leave it, where widths were averaged over; so the
    eigenvalues of W^T W count up to 1.
    """
    P = posterior.covariance
    samples = _whitened_samples(posterior)
    squares = np.sum((samples.q[:, None] - samples.q) ** 2, axis=2)
    kernels = np.exp(-0.5 * squares / np.square(LENGTHS)[:, None, None])
    some = evenly(len(samples.q), MOST)
    few = samples.residuals[some], samples.slopes[some]
    shared = _shared_variance(*few, P, kernels[:, some[:, None], some])
    R = Gaussian.of(np.zeros(len(P)), P).root
    W = (samples.slopes @ R).transpose(1, 2, 0)  # axis, unknown, sample
    across = W.transpose(0, 2, 1)
    correlated = W @ np.tensordot(shared, kernels, axes=1) @ across
    eigenvalues, axes = np.linalg.eigh(np.sum(W @ across, axis=0))
    independent = axes * (1 - shared.sum() * eigenvalues.clip(max=1.0)) @ axes.T
    root = R[: posterior.model.size]
    return root @ (independent + correlated.sum(axis=0)) @ root.T


def _shared_variance(
    u: np.ndarray, A: np.ndarray, P: np.ndarray, kernels: np.ndarray
) -> np.ndarray:
    """Return the share rho of errors that is alike over each length, its mean by the evidence.

    A fit leaves u = (1 - A P A^T) e of errors e. With lambda and V the eigenvalues and axes of
    that, V^T e = V^T u / lambda has the covariance (1 - rho) 1 + rho V^T K V where lambda is not 0.

    Args:
        u: Whitened residuals, shape (N, 3).
        A: Whitened derivatives by all unknowns, shape (N, 3, n).
        P: Posterior covariance of these, shape (n, n).
        kernels: K over each length, shape (L, N, N).
    """
    by_axis = A.transpose(1, 0, 2).reshape(u.size, -1)
    eigenvalues, axes = np.linalg.eigh(np.eye(u.size) - by_axis @ P @ by_axis.T)
    remaining = eigenvalues > DECIDED
    axes = axes[:, remaining]
    errors = axes.T @ u.T.ravel() / eigenvalues[remaining]
    V = axes.reshape(3, len(u), -1)
    logs: list[np.ndarray] = []
    for K in kernels:
        k, turn = np.linalg.eigh(np.sum(V.transpose(0, 2, 1) @ K @ V, axis=0))
        variances = 1 - SHARES + SHARES * k.clip(min=0.0)
        squares = (turn.T @ errors) ** 2
        logs.append(-0.5 * np.sum(np.log(variances) + squares / variances, axis=1))
    return probabilities(np.array(logs)) @ SHARES[:, 0]
