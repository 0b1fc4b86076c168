"""Uncertainty of a calibration: standard deviations, correlations, predicted errors."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ...data import IDENTITY
from ...results import Correlation, Scale
from ..inference import Posterior
from ..model import ExtendedModel, Gaussian, PriorGroup, submatrix

LENGTHS = (0.3, 0.6, 1.2, 2.4)
"""In joint space, over which errors are alike [rad]."""
SHARES = np.linspace(0, 0.9, 10)[:, None]
"""Of the errors' variance that is alike."""
MOST, DECIDED = 150, 1e-3
"""Samples that tell of it at most; and variance below which a fit leaves nothing of an error."""
UNDECIDED = 0.5
"""The data did not decide a direction if its posterior is wider than this share of its prior."""
STRONG = 0.9
"""Correlations of two unknowns beyond this are reported."""
CORRELATED = 3
"""Variance of the mean of samples in a socket, relative to that of independent ones: the errors of
a sample and the next are correlated by about a half."""
BATCH = 500
"""Samples whose derivatives by all unknowns are held at once."""


def with_correlated_errors(posterior: Posterior) -> np.ndarray:
    """Return the covariance of the model's unknowns where play moves samples alike (A11)."""
    model = posterior.model
    data = posterior.data
    P = posterior.covariance
    rows = np.flatnonzero(data.sockets >= 0)
    q = data.positions[rows]
    N = len(rows)
    size = model.size
    samples = q, data.torques[rows], data.clocks[rows]
    points, by_unknowns, by_joints = model.linearise(posterior.x, *samples)
    slopes = np.zeros((N, 3, len(P)))
    slopes[:, :, :size] = by_unknowns
    centres = size + 3 * data.sockets[rows, None] + np.arange(3)
    slopes[np.arange(N)[:, None], np.arange(3), centres] = -1
    residuals = points - posterior.centres[data.sockets[rows]]
    root = np.linalg.cholesky(posterior.noise.as_gaussian(by_joints))
    white = np.linalg.solve(root, np.concatenate([residuals[:, :, None], slopes], axis=2))
    squares = np.sum((q[:, None] - q) ** 2, axis=2)
    kernels = np.exp(-0.5 * squares / np.square(LENGTHS)[:, None, None])
    some = np.unique(np.linspace(0, N - 1, min(N, MOST)).astype(int))
    shared = _shared_variance(
        white[some, :, 0], white[some, :, 1:], P, kernels[:, some[:, None], some]
    )
    R = Gaussian.of(np.zeros(len(P)), P).root
    W = (white[:, :, 1:] @ R).transpose(1, 2, 0)
    correlated = W @ np.tensordot(shared, kernels, axes=1) @ W.transpose(0, 2, 1)
    # P is wider than the samples alone would leave it, where widths were averaged over.
    eigenvalues, axes = np.linalg.eigh(np.sum(W @ W.transpose(0, 2, 1), axis=0))
    residuals = axes * (1 - shared.sum() * eigenvalues.clip(max=1.0)) @ axes.T
    return R[:size] @ (residuals + correlated.sum(axis=0)) @ R[:size].T


def _shared_variance(
    u: np.ndarray, A: np.ndarray, P: np.ndarray, kernels: np.ndarray
) -> np.ndarray:
    """Return the share of errors that is alike over each length, its mean by the evidence."""
    n = 3 * len(u)
    flat = A.transpose(1, 0, 2).reshape(3 * len(u), -1)
    eigenvalues, axes = np.linalg.eigh(np.eye(n) - flat @ P @ flat.T)
    axes = axes[:, eigenvalues > DECIDED]
    errors = axes.T @ u.T.ravel() / eigenvalues[eigenvalues > DECIDED]
    by_axis = axes.reshape(3, len(u), -1)
    logs: list[np.ndarray] = []
    for K in kernels:
        k, V = np.linalg.eigh(np.sum(by_axis.transpose(0, 2, 1) @ K @ by_axis, axis=0))
        variances = 1 - SHARES + SHARES * k.clip(min=0.0)
        logs.append(-0.5 * np.sum(np.log(variances) + (V.T @ errors) ** 2 / variances, axis=1))
    odds: np.ndarray = np.exp(np.array(logs) - np.max(logs))
    return odds @ SHARES[:, 0] / odds.sum()


def deviations(posterior: Posterior) -> np.ndarray:
    """Return the posterior standard deviation of each of the model's unknowns, shape (size,)."""
    return np.sqrt(np.diag(posterior.covariance)[: posterior.model.size])


def effective_parameters(posterior: Posterior, group: PriorGroup) -> float:
    """Return how many of a group's unknowns the data decide; the rest stays with its prior."""
    if group.learned:
        return group.effective
    before = np.diag(group.covariance(group.deviation))
    after = np.diag(posterior.covariance)[group.members]
    positive = before > 0
    return max(float(np.sum(1 - after[positive] / before[positive])), 0.0)


def correlations(posterior: Posterior) -> tuple[Correlation, ...]:
    """Return unknowns correlated beyond :data:`STRONG`, the closest pair first."""
    size = posterior.model.scalars
    deviation = deviations(posterior)[:size]
    prior = np.diag(posterior.prior_covariance) ** 0.5
    decided = np.flatnonzero((deviation > 0) & (deviation < UNDECIDED * prior))
    covariance = submatrix(posterior.covariance, decided)
    matrix = covariance / np.outer(deviation[decided], deviation[decided])
    names = [posterior.model.names[i] for i in decided.tolist()]
    pairs = np.argwhere(np.triu(np.abs(matrix) > STRONG, k=1)).tolist()
    pairs_of_names = [Correlation(names[i], names[j], float(matrix[i, j])) for i, j in pairs]
    return tuple(sorted(pairs_of_names, key=lambda pair: -abs(pair.value)))


def observability_index(posterior: Posterior) -> float:
    """Return how well the configurations show the geometry: O1 of Borm and Menq (1991).

        O1 = (s_1 s_2 ... s_L)^(1/L) / sqrt(N)

    s_1 >= s_2 >= ... are the singular values of the derivatives of the N ball positions by the
    geometry, without what the places of sockets and frames explain, each parameter in units of its
    prior's standard deviation; L of them are not zero (s > 1e-6 s_1).
    """
    model = posterior.model
    data = posterior.data
    samples = data.positions, data.torques, data.clocks
    true = posterior.deflection.true_positions(*samples)
    linear = model.ball.linearise(posterior.values, true)
    points = linear.points
    prior = np.sqrt(np.diag(posterior.prior_covariance))
    scaled = linear.by_parameters * prior[: model.geometry]
    parts = [scaled[data.sockets == k] for k in range(data.socket_count)]
    parts = [rows - rows.mean(axis=0) for rows in parts if len(rows)]
    for k in range(len(data.frames)):
        rows = data.measured_in == k
        slopes = IDENTITY.slopes(points[rows]).reshape(-1, 6)
        visible = scaled[rows].reshape(-1, model.geometry)
        parts.append(visible - slopes @ np.linalg.lstsq(slopes, visible, rcond=None)[0])
    centred = np.concatenate([rows.reshape(-1, model.geometry) for rows in parts])
    values = np.linalg.svd(centred, compute_uv=False)
    values = values[values > 1e-6 * values[0]]
    return float(np.exp(np.mean(np.log(values))) / np.sqrt(len(data.positions)))


def distance_slopes(
    model: ExtendedModel, x: np.ndarray, q: np.ndarray, torque: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return distances between pairs of ball positions, shape (N,), and derivatives (N, size).

    Joint positions q have shape (2 N, m) [rad], rows 0 and 1, 2 and 3, ... being pairs, and what
    holds their joints (2 N, 3 m) [N m].
    """
    points, jacobian, _ = model.linearise(x, q, torque)
    offset = points[1::2] - points[::2]
    distances: np.ndarray = np.linalg.norm(offset, axis=1).clip(1e-12)
    direction = offset / distances[:, None]
    return distances, np.einsum("ni,nij->nj", direction, jacobian[1::2] - jacobian[::2])


def distance_deviations(
    posterior: Posterior, q: np.ndarray, torque: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of :func:`distance_slopes`, and their standard deviations [m]."""
    distances, slopes = distance_slopes(posterior.model, posterior.x, q, torque)
    covariance = covariance_of(posterior)
    return distances, np.sqrt(np.sum((slopes @ covariance) * slopes, axis=1))


@lru_cache(maxsize=1)  # it takes a while
def covariance_of(posterior: Posterior) -> np.ndarray:
    """Return the covariance of the model's unknowns; play moves samples of servos together."""
    size = posterior.model.size
    if any(effect.zeros for effect in posterior.model.effects):
        return with_correlated_errors(posterior)
    return posterior.covariance[:size, :size]


def predicted_deviation(
    posterior: Posterior, by_socket: Sequence[tuple[np.ndarray, np.ndarray]]
) -> float:
    """Return how far samples should lie from their socket's mean, noise included, as rms [m].

    For each socket, ``by_socket`` has joint positions [rad] and torques [N m] of its samples.
    """
    size = posterior.model.size
    covariance = posterior.covariance[:size, :size]
    total = 0.0
    count = 0
    for q, torque in by_socket:
        sums = np.zeros((3, size))
        noise = 0.0
        for begin in range(0, len(q), BATCH):
            some = slice(begin, begin + BATCH)
            _, J, by_joints = posterior.model.linearise(posterior.x, q[some], torque[some])
            total += sum(sum_of_variances(rows, covariance) for rows in J)
            sums += J.sum(axis=0)
            noise += float(np.trace(posterior.noise.as_gaussian(by_joints), axis1=1, axis2=2).sum())
        total -= float(np.sum((sums @ covariance) * sums)) / len(q)
        total += noise * (1 - 1 / len(q))
        count += len(q)
    return (total / count) ** 0.5


def sum_of_variances(rows: np.ndarray, covariance: np.ndarray) -> float:
    """Return the sum of rows' variances; of a curve, a sample has but four coefficients."""
    columns = np.flatnonzero(rows.any(axis=0))
    few = rows[:, columns]
    return float(np.sum((few @ covariance[columns[:, None], columns]) * few))


def length_deviation(
    posterior: Posterior, by_socket: Sequence[tuple[np.ndarray, np.ndarray]], measured: float
) -> float:
    """Return the standard deviation of a placement's distance error by the full model [m].

    The first two sockets of ``by_socket`` count, and their distance is measured to ``measured``
    [m].
    """
    centres: list[np.ndarray] = []
    slopes: list[np.ndarray] = []
    noise = np.zeros((3, 3))
    for q, torque in by_socket[:2]:
        points, jacobian, by_joints = posterior.model.linearise(posterior.x, q, torque)
        centres.append(points.mean(axis=0))
        slopes.append(jacobian.mean(axis=0))
        noise += CORRELATED * posterior.noise.as_gaussian(by_joints).sum(axis=0) / len(q) ** 2
    offset = centres[1] - centres[0]
    direction = offset / max(float(np.linalg.norm(offset)), 1e-12)
    slope = direction @ (slopes[1] - slopes[0])
    variance = slope @ covariance_of(posterior) @ slope + direction @ noise @ direction
    return float(variance + measured**2) ** 0.5


def scale(posterior: Posterior) -> Scale:
    """Return by how much the arm came out larger than its model.

    A real arm is within some 0.003 of its model; one that came out beyond had most likely a wrong
    distance between its sockets.
    """
    by_scale = posterior.model.by_scale()
    variance = float(by_scale @ covariance_of(posterior) @ by_scale)
    return Scale(value=float(by_scale @ posterior.x), deviation=variance**0.5)
