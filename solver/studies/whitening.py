"""Samples whose noise is made one, L^-1 before their columns with L L^T the noise of a sample.

And by them the posterior covariance of arms whose gears have play, which moves samples alike.
"""

from typing import NamedTuple

import numpy as np

from ..identification.inference import Posterior
from ..identification.model import Gaussian, probabilities
from .projections import basis_of, evenly, kernels, outside, rows_of


class WhitenedSamples(NamedTuple):
    """N samples in sockets, their noise made one."""

    q: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    residuals: np.ndarray
    """Shape (N, 3)."""
    slopes: np.ndarray
    """A: derivatives of the residuals by the model's unknowns and the centres, shape (N, 3, n)."""


def samples_in_sockets(posterior: Posterior) -> WhitenedSamples:
    """Return the samples in sockets of a fit, without what differs between places could explain."""
    data = posterior.data
    samples = data.only(data.seated)
    _, J, by_joints = posterior.linearise(samples)
    in_socket = np.eye(len(posterior.centres))[samples.sockets]
    by_centres = np.kron(in_socket, -np.eye(3)).reshape(len(J), 3, -1)
    columns = np.dstack([posterior.residuals, J, by_centres])
    white = whitened(posterior, by_joints, columns)
    if posterior.by_differences is not None:
        D = posterior.by_differences[data.seated]
        Q = basis_of(whitened(posterior, by_joints, D))
        white = outside(rows_of(white), Q).reshape(white.shape)
    return WhitenedSamples(samples.q, white[:, :, 0], white[:, :, 1:])


def whitened(
    posterior: Posterior,
    by_joints: np.ndarray,
    columns: np.ndarray,
) -> np.ndarray:
    """Return L^-1 B of samples' columns B, shape (N, 3, k), by their derivatives by the joints."""
    L = np.linalg.cholesky(posterior.noise.as_gaussian(by_joints))
    return np.linalg.solve(L, columns)


LENGTHS = (0.3, 0.6, 1.2, 2.4)
"""In joint space, over which errors are alike [rad]."""
SHARES = np.linspace(0, 0.9, 10)[:, None]
"""Of the errors' variance that is alike."""
MOST, DECIDED = 150, 1e-3
"""Samples that tell of it at most; and variance below which a fit leaves nothing of an error."""


def with_correlated_errors(posterior: Posterior) -> np.ndarray:
    """Return the covariance of the model's unknowns where play moves samples alike (A11).

    With P = R R^T and W = A R, it is the sum over axes and lengths l in

        R (1 - rho W^T W + rho W^T K W) R^T,    K_ij = exp(-|q_i - q_j|^2 / 2 l^2)

    P is wider than the samples alone would leave it, where widths were averaged over; so the
    eigenvalues of W^T W count up to 1.
    """
    P = posterior.covariance
    q, residuals, A = samples_in_sockets(posterior)
    K = kernels(q, LENGTHS)
    some = evenly(len(q), MOST)
    shared = _shared_variance(
        residuals[some],
        A[some],
        P,
        K[:, some[:, None], some],
    )
    R = Gaussian.of(np.zeros(len(P)), P).root
    W = (A @ R).transpose(1, 0, 2)  # axis, sample, unknown
    across = W.swapaxes(1, 2)
    rho_K = np.tensordot(shared, K, axes=1)
    correlated = np.sum(across @ rho_K @ W, axis=0)
    information = np.sum(across @ W, axis=0)
    eigenvalues, axes = np.linalg.eigh(information)
    lost = shared.sum() * eigenvalues.clip(max=1.0)
    independent = axes * (1 - lost) @ axes.T
    root = R[: posterior.model.size]
    return root @ (independent + correlated) @ root.T


def _shared_variance(
    u: np.ndarray,
    A: np.ndarray,
    P: np.ndarray,
    K: np.ndarray,
) -> np.ndarray:
    """Return the share rho of errors that is alike over each length, its mean by the evidence.

    A fit leaves u = (1 - A P A^T) e of errors e. With lambda and V the eigenvalues and axes of
    that, V^T e = V^T u / lambda has the covariance (1 - rho) 1 + rho V^T K V where lambda is not 0.

    Args:
        u: Whitened residuals, shape (N, 3).
        A: Whitened derivatives by all unknowns, shape (N, 3, n).
        P: Posterior covariance of these, shape (n, n).
        K: Over each length, shape (L, N, N).
    """
    numbers = u.size
    by_axis = A.transpose(1, 0, 2).reshape(numbers, -1)
    shrinking = np.eye(numbers) - by_axis @ P @ by_axis.T
    eigenvalues, axes = np.linalg.eigh(shrinking)
    is_left = eigenvalues > DECIDED
    axes = axes[:, is_left]
    errors = axes.T @ u.T.ravel() / eigenvalues[is_left]
    V = axes.reshape(3, len(u), -1)
    inner = np.sum(V.swapaxes(1, 2) @ (K[:, None] @ V), axis=1)
    k, turns = np.linalg.eigh(inner)
    squares = (errors @ turns) ** 2
    k = k.clip(min=0.0)[:, None]
    variances = 1 - SHARES + SHARES * k
    terms = np.log(variances) + squares[:, None] / variances
    log_likelihoods = -0.5 * terms.sum(axis=2)
    return probabilities(log_likelihoods) @ SHARES[:, 0]
