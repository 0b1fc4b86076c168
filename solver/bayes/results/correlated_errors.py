"""Posteriors where errors of samples in poses alike are alike, as play of the gears makes them.

A fit takes the whitened errors e of its samples for independent. Let them rather scatter by

    C = (1 - rho) I + rho K,    K_ij = exp(-|q_i - q_j|^2 / 2 l^2)

on each axis. A fit with slopes A and posterior P leaves u = (I - A P A^T) e of them, whose
likelihood tells the share rho and the length l in joint space. The posterior of the same fit,
averaged over both, is then P + P A^T (C - I) A P (a sandwich, Huber 1967).
"""

import numpy as np

from ..inference import Posterior

LENGTHS = (0.3, 0.6, 1.2, 2.4)
"""In joint space, over which errors are alike [rad]."""
SHARES = np.linspace(0, 0.9, 10)[:, None]
"""Of the errors' variance that is alike."""
MOST, DECIDED = 150, 1e-3
"""Samples that tell of it at most; and variance below which a fit leaves nothing of an error."""


def with_correlated_errors(posterior: Posterior) -> np.ndarray:
    """Return the covariance of the model's unknowns, shape (size, size)."""
    model, data, P = posterior.model, posterior.data, posterior.covariance
    rows = np.flatnonzero(data.sockets >= 0)
    q, N, size = data.positions[rows], len(rows), model.size
    points, by_unknowns, by_joints = model.linearise(posterior.x, q, data.torques[rows])
    slopes = np.zeros((N, 3, len(P)))
    slopes[:, :, :size] = by_unknowns
    centres = size + 3 * data.sockets[rows, None] + np.arange(3)
    slopes[np.arange(N)[:, None], np.arange(3), centres] = -1
    left = points - posterior.centres[data.sockets[rows]]
    root = np.linalg.cholesky(posterior.noise.as_gaussian(by_joints))
    white = np.linalg.solve(root, np.concatenate([left[:, :, None], slopes], axis=2))
    apart = np.sum((q[:, None] - q) ** 2, axis=2)
    kernels = np.exp(-0.5 * apart / np.square(LENGTHS)[:, None, None])
    some = np.unique(np.linspace(0, N - 1, min(N, MOST)).astype(int))
    alike = _alike(white[some, :, 0], white[some, :, 1:], P, kernels[:, some[:, None], some])
    C = np.tensordot(alike, kernels - np.eye(N), axes=1)
    back = P[:size] @ white[:, :, 1:].transpose(1, 2, 0)
    return P[:size, :size] + np.sum(back @ C @ back.transpose(0, 2, 1), axis=0)


def _alike(u: np.ndarray, A: np.ndarray, P: np.ndarray, kernels: np.ndarray) -> np.ndarray:
    """Return the share of errors that is alike over each length, its mean by the evidence."""
    n, flat = 3 * len(u), A.transpose(1, 0, 2).reshape(3 * len(u), -1)
    left, axes = np.linalg.eigh(np.eye(n) - flat @ P @ flat.T)
    axes = axes[:, left > DECIDED]
    errors = axes.T @ u.T.ravel() / left[left > DECIDED]
    by_axis = axes.reshape(3, len(u), -1)
    logs: list[np.ndarray] = []
    for K in kernels:
        k, V = np.linalg.eigh(np.sum(by_axis.transpose(0, 2, 1) @ K @ by_axis, axis=0))
        variances = 1 - SHARES + SHARES * k.clip(min=0.0)
        logs.append(-0.5 * np.sum(np.log(variances) + (V.T @ errors) ** 2 / variances, axis=1))
    odds: np.ndarray = np.exp(np.array(logs) - np.max(logs))
    return odds @ SHARES[:, 0] / odds.sum()
