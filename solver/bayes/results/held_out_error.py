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

from ...results import ErrorParts, Interval
from ..inference import Posterior
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
Samples = tuple[np.ndarray, np.ndarray]
"""Joint positions [rad] and moments [N m] of one socket."""


def error_parts(posterior: Posterior, sockets: Sequence[Samples]) -> ErrorParts | None:
    """Return the parts of the error at held-out sockets; None for too few samples."""
    total = sum(len(q) for q, _ in sockets)
    step = -(-total // MOST)
    sockets = [(q[::step], moments[::step]) for q, moments in sockets if len(q) > 2 * step]
    if not sockets:
        return None
    Q = _contrasts([len(q) for q, _ in sockets])
    q = np.concatenate([q for q, _ in sockets])
    moments = np.concatenate([moments for _, moments in sockets])
    points, J, by_joints = posterior.model.linearise(posterior.x, q, moments)
    C = _blocks(posterior.noise.as_gaussian(by_joints))
    A = Q.T @ J.reshape(len(Q), -1)
    want = A @ covariance_of(posterior) @ A.T
    noise = Q.T @ C @ Q
    errors = Q.T @ points.ravel()
    count = len(q)
    expected = np.trace(want + noise)
    kernels = [Q.T @ K @ Q for K in _kernels(q, moments, by_joints)]
    kernels = [K * expected / np.trace(K) for K in kernels if np.trace(K) > 0]
    logs = np.array([[_logs(want + n * noise, K, errors) for n in NOISES] for K in kernels])
    logs -= np.square(np.log(NOISES) / 2 / NOISE_DEVIATION)[:, None] / 2
    logs[..., 0] += np.log(len(SIZES) - 1)
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    by_noise = weights.sum(axis=(0, 2))
    by_size = weights.sum(axis=(0, 1))
    parts = np.array(
        [by_noise @ NOISES * np.trace(noise), np.trace(want), by_size @ SIZES * expected]
    )
    error = float(errors @ errors)
    scale = error / parts.sum()
    low, high = SIZES[np.searchsorted(np.cumsum(by_size), LEVELS)]
    roots = np.sqrt(scale * parts / count).tolist()
    squares = np.minimum([scale * expected * low, scale * expected * high], error)
    low, high = np.sqrt(squares / count).tolist()
    return ErrorParts(
        error=(error / count) ** 0.5,
        noise=roots[0],
        want_of_data=roots[1],
        not_in_model=Interval(value=roots[2], low=low, high=high),
    )


def _contrasts(counts: Sequence[int]) -> np.ndarray:
    """Return Q for sockets with so many samples, shape (3 N, 3 (N - sockets))."""
    blocks: list[np.ndarray] = []
    for count in counts:
        mean = np.full((count, 1), count**-0.5)
        blocks.append(np.linalg.qr(np.hstack([mean, np.eye(count)[:, 1:]]))[0][:, 1:])
    N = sum(counts)
    Q = np.zeros((N, N - len(counts)))
    row = 0
    column = 0
    for block in blocks:
        rows, columns = block.shape
        Q[row : row + rows, column : column + columns] = block
        row = row + rows
        column = column + columns
    return np.kron(Q, np.eye(3))


def _blocks(values: np.ndarray) -> np.ndarray:
    """Return a block diagonal matrix of matrices, shape (N, 3, 3), as (3 N, 3 N)."""
    N = len(values)
    matrix = np.zeros((N, 3, N, 3))
    matrix[np.arange(N), :, np.arange(N)] = values
    return matrix.reshape(3 * N, 3 * N)


def _kernels(q: np.ndarray, moments: np.ndarray, by_joints: np.ndarray) -> Iterator[np.ndarray]:
    """Yield covariances of errors that a model may lack, shape (3 N, 3 N)."""
    squares = np.sum((q[:, None] - q) ** 2, axis=2)
    for length in LENGTHS:
        yield np.kron(np.exp(-0.5 * squares / length**2), np.eye(3))
    for j in range(q.shape[1]):
        along = by_joints[:, :, j].ravel()
        turned = np.outer(along, along)
        half = np.sin((q[:, None, j] - q[:, j]) / 2)
        for length in TURNS:
            yield turned * np.kron(np.exp(-2 * (half / length) ** 2), np.ones((3, 3)))
        pushed = np.sign(moments[:, j])
        yield turned * np.kron(np.outer(pushed, pushed), np.ones((3, 3)))


def _logs(S: np.ndarray, K: np.ndarray, errors: np.ndarray) -> np.ndarray:
    """Return log N(errors; 0, S + m^2 K) for all m^2 of :data:`SIZES`."""
    L = np.linalg.cholesky(S)
    white = np.linalg.solve(L, np.linalg.solve(L, K).T)
    shares, axes = np.linalg.eigh((white + white.T) / 2)
    z = axes.T @ np.linalg.solve(L, errors)
    variances = 1 + SIZES[:, None] * shares.clip(min=0)
    return -0.5 * np.sum(np.log(variances) + z**2 / variances, axis=1) - np.log(np.diag(L)).sum()
