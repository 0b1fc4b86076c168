"""The posterior covariance of arms whose gears have play, which moves samples alike."""

import numpy as np

from ..inference import Posterior
from ..model import Gaussian, probabilities
from .projections import evenly
from .whitening import samples_in_sockets

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
    squares = np.sum((q[:, None] - q) ** 2, axis=2)
    lengths = np.array(LENGTHS)[:, None, None]
    kernels = np.exp(-0.5 * squares / lengths**2)
    some = evenly(len(q), MOST)
    kernels_of_some = kernels[:, some[:, None], some]
    shared = _shared_variance(residuals[some], A[some], P, kernels_of_some)
    R = Gaussian.of(np.zeros(len(P)), P).root
    W = (A @ R).transpose(1, 0, 2)  # axis, sample, unknown
    across = W.swapaxes(1, 2)
    rho_K = np.tensordot(shared, kernels, axes=1)
    correlated = np.sum(across @ rho_K @ W, axis=0)
    eigenvalues, axes = np.linalg.eigh(np.sum(across @ W, axis=0))
    remaining = 1 - shared.sum() * eigenvalues.clip(max=1.0)
    independent = axes * remaining @ axes.T
    root = R[: posterior.model.size]
    return root @ (independent + correlated) @ root.T


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
    shrinking = np.eye(u.size) - by_axis @ P @ by_axis.T
    eigenvalues, axes = np.linalg.eigh(shrinking)
    left = eigenvalues > DECIDED
    axes = axes[:, left]
    errors = axes.T @ u.T.ravel() / eigenvalues[left]
    V = axes.reshape(3, len(u), -1)
    inner = np.sum(V.swapaxes(1, 2) @ (kernels[:, None] @ V), axis=1)
    k, turns = np.linalg.eigh(inner)
    squares = (errors @ turns) ** 2
    variances = 1 - SHARES + SHARES * k.clip(min=0.0)[:, None]
    terms = np.log(variances) + squares[:, None] / variances
    return probabilities(-0.5 * terms.sum(axis=2)) @ SHARES[:, 0]
