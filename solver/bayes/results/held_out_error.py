"""The held-out error in three: noise, want of data, and what is not in the model.

With Q an orthonormal basis of the samples' deviations from their socket's mean, the errors at
held-out places are Gaussian with the covariance

    Q^T (J Sigma J^T + n^2 C + m^2 K) Q

by the posterior of the unknowns, by noise C of the fit's shape, and by what the model lacks: an
error K that samples have in common whose joints stand alike, or one whose joint is pushed alike.
The evidence of the errors, over all K and over n and m, tells how large n and m are. An effect that
changes from each sample to the next is no different from noise, and counts as noise.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from ...data import SocketSamples
from ...results import ErrorParts, Interval
from ..inference import Posterior
from ..model import probabilities
from .projections import block_diagonal
from .uncertainty import covariance_of

MOST = 72
"""Held-out samples that are looked at, at most."""
TURNS = (0.3, 1.0)
"""Lengths in the angle of one joint, over which its error is alike [rad]."""
LENGTHS = (0.6, 1.5)
"""Lengths in joint space, over which all errors are alike [rad]."""
NOISES = np.geomspace(0.3, 1.5, 8) ** 2
"""n^2, by the noise of the fit, which holds part of what the model lacks."""
NOISE_DEVIATION = 0.5
"""Standard deviation of log n by the prior."""
SIZES = np.concatenate([[0.0], np.geomspace(0.05, 4.0, 24) ** 2])
"""m^2, by the mean square error that is expected without; the first has half of the prior."""
LEVELS = (0.025, 0.975)


def error_parts(posterior: Posterior, sockets: Sequence[SocketSamples]) -> ErrorParts | None:
    """Return the parts of the error at held-out sockets; None for too few samples.

    Their expected squares are n^2 tr Q^T C Q, tr Q^T J Sigma J^T Q, and m^2 times the sum of both
    for n = 1. They are scaled to sum to the square of the error that was found.
    """
    total = sum(len(q) for q, _ in sockets)
    step = -(-total // MOST)
    thinned = [(q[::step], moments[::step]) for q, moments in sockets if len(q) > 2 * step]
    if not thinned:
        return None
    Q = _contrasts([len(q) for q, _ in thinned])
    q = np.concatenate([q for q, _ in thinned])
    moments = np.concatenate([moments for _, moments in thinned])
    points, J, by_joints = posterior.linearise(q, moments)
    A = Q.T @ J.reshape(len(Q), -1)
    want = A @ covariance_of(posterior) @ A.T
    noise = Q.T @ block_diagonal(posterior.noise.as_gaussian(by_joints)) @ Q
    kernels = [Q.T @ K @ Q for K in _kernels(q, moments, by_joints)]
    errors = Q.T @ points.ravel()
    weights = _weights(want, noise, kernels, errors)
    by_noise = weights.sum(axis=(0, 2))
    by_size = weights.sum(axis=(0, 1))
    expected = np.trace(want + noise)
    of_noise = by_noise @ NOISES * np.trace(noise)
    parts = np.array([of_noise, np.trace(want), by_size @ SIZES * expected])
    error = float(errors @ errors)
    scale = error / parts.sum()
    ends = SIZES[np.searchsorted(np.cumsum(by_size), LEVELS)]
    squares = np.append(scale * parts, np.minimum(scale * expected * ends, error))
    of_noise, of_want, of_model, low, high = np.sqrt(squares / len(q)).tolist()
    return ErrorParts(
        error=(error / len(q)) ** 0.5,
        noise=of_noise,
        want_of_data=of_want,
        not_in_model=Interval(value=of_model, low=low, high=high),
    )


def _weights(
    want: np.ndarray, noise: np.ndarray, kernels: Sequence[np.ndarray], errors: np.ndarray
) -> np.ndarray:
    """Return the probability of each K, n and m by the errors, shape (kernels, n, m).

    The evidence is N(errors; 0, want + n^2 noise + m^2 K), with K as large as the first two for
    n = 1. Log n has a normal prior, and m = 0 as much of the prior as all others together.
    """
    expected = np.trace(want + noise)
    scaled = [K * expected / np.trace(K) for K in kernels if np.trace(K) > 0]
    logs = np.array([[_logs(want + n * noise, K, errors) for n in NOISES] for K in scaled])
    logs -= np.square(np.log(NOISES) / 2 / NOISE_DEVIATION)[:, None] / 2
    logs[..., 0] += np.log(len(SIZES) - 1)
    return probabilities(logs)


def _contrasts(counts: Sequence[int]) -> np.ndarray:
    """Return Q for sockets with so many samples, shape (3 N, 3 (N - sockets))."""
    blocks: list[np.ndarray] = []
    for count in counts:
        columns = np.eye(count)
        columns[:, 0] = 1.0  # the mean first, so that the others' basis is free of it
        blocks.append(np.linalg.qr(columns)[0][:, 1:])
    return np.kron(block_diagonal(blocks), np.eye(3))


def _kernels(q: np.ndarray, moments: np.ndarray, by_joints: np.ndarray) -> Iterator[np.ndarray]:
    """Yield covariances of errors that a model may lack, shape (3 N, 3 N).

    Of samples a and b these are exp(-|q_a - q_b|^2 / 2 l^2) along each axis alone; and with j_a
    how the ball moves by a joint, j_a j_b^T times exp(-2 sin^2((q_a - q_b) / 2) / l^2) of its
    angle, or times the sign by which gravity pushes it in both.
    """
    differences = q[:, None] - q
    squares = np.sum(differences**2, axis=2)
    for length in LENGTHS:
        yield np.kron(np.exp(-0.5 * squares / length**2), np.eye(3))
    all_axes = np.ones((3, 3))
    for j in range(q.shape[1]):
        along = by_joints[:, :, j].ravel()
        turned = np.outer(along, along)
        half = np.sin(differences[:, :, j] / 2)
        for length in TURNS:
            yield turned * np.kron(np.exp(-2 * (half / length) ** 2), all_axes)
        pushed = np.sign(moments[:, j])
        yield turned * np.kron(np.outer(pushed, pushed), all_axes)


def _logs(S: np.ndarray, K: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Return log N(errors; 0, S + m^2 K) for all m^2 of :data:`SIZES`.

    With S = L L^T, L^-1 K L^-T = V diag(k) V^T and z = V^T L^-1 e, it is, but for a constant,

        -1/2 sum_i [log(1 + m^2 k_i) + z_i^2 / (1 + m^2 k_i)] - log det L
    """
    L = np.linalg.cholesky(S)
    white = np.linalg.solve(L, np.linalg.solve(L, K).T)
    shares, axes = np.linalg.eigh((white + white.T) / 2)
    z = axes.T @ np.linalg.solve(L, errors)
    variances = 1 + SIZES[:, None] * shares.clip(min=0)
    return -0.5 * np.sum(np.log(variances) + z**2 / variances, axis=1) - np.log(np.diag(L)).sum()
