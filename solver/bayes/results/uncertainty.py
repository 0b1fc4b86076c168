"""Uncertainty of a calibration: standard deviations, correlations, predicted errors."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ...data import IDENTITY, SocketSamples
from ...results import Correlation, Scale
from ..inference import Posterior
from ..model import ExtendedModel, PriorGroup, submatrix
from .correlated_errors import with_correlated_errors
from .projections import basis_of, outside, rows_of

UNDECIDED = 0.5
"""The data did not decide a direction if its posterior is wider than this share of its prior."""
STRONG = 0.9
"""Correlations of two unknowns beyond this are reported."""
BATCH = 500
"""Samples whose derivatives by all unknowns are held at once."""


def deviations(posterior: Posterior) -> np.ndarray:
    """Return the posterior standard deviation of each of the model's unknowns, shape (size,)."""
    return np.sqrt(np.diag(posterior.covariance)[: posterior.model.size])


def effective_parameters(posterior: Posterior, group: PriorGroup) -> float:
    """Return gamma: how many of a group's unknowns the data decide.

    Without one by the estimation, it is the sum of 1 - s^2 / s_prior^2 of the unknowns.
    """
    if group.learned:
        return group.effective
    before = np.diag(group.covariance(group.deviation))
    after = np.diag(posterior.covariance)[group.members]
    free = before > 0
    decided_shares = 1 - after[free] / before[free]
    return max(float(decided_shares.sum()), 0.0)


def correlations(posterior: Posterior) -> tuple[Correlation, ...]:
    """Return unknowns correlated beyond :data:`STRONG`, the closest pair first."""
    size = posterior.model.scalars
    deviation = deviations(posterior)[:size]
    prior = np.diag(posterior.prior_covariance) ** 0.5
    decided = np.flatnonzero((deviation > 0) & (deviation < UNDECIDED * prior))
    deviation = deviation[decided]
    matrix = submatrix(posterior.covariance, decided) / np.outer(deviation, deviation)
    names = [posterior.model.names[i] for i in decided]
    strong = np.triu(np.abs(matrix) > STRONG, k=1)
    pairs = [
        Correlation(names[i], names[j], float(matrix[i, j]))
        for i, j in np.argwhere(strong).tolist()
    ]
    return tuple(sorted(pairs, key=lambda pair: -abs(pair.value)))


def observability_index(posterior: Posterior) -> float:
    """Return how well the configurations show the geometry: O1 of Borm and Menq (1991).

        O1 = (s_1 s_2 ... s_L)^(1/L) / sqrt(N)

    s_1 >= s_2 >= ... are the singular values of the derivatives of the N ball positions by the
    geometry, without what the places of sockets and frames explain, each parameter in units of its
    prior's standard deviation; L of them are not zero (s > 1e-6 s_1).
    """
    model = posterior.model
    data = posterior.data
    true = posterior.deflection.true_positions(
        data.positions, data.torques, data.clocks
    )
    linear = model.ball.linearise(posterior.values, true)
    prior = np.sqrt(np.diag(posterior.prior_covariance))
    scaled = linear.by_parameters * prior[: model.geometry]
    motions = IDENTITY.slopes(linear.points)
    shifts = motions[:, :, 3:]
    places = [(data.sockets == k, shifts) for k in range(data.socket_count)]
    places += [(data.measured_in == k, motions) for k in range(len(data.frames))]
    centred: list[np.ndarray] = []
    for rows, changes in places:
        if rows.any():
            Q = basis_of(changes[rows])
            centred.append(outside(rows_of(scaled[rows]), Q))
    values = np.linalg.svd(np.concatenate(centred), compute_uv=False)
    values = values[values > 1e-6 * values[0]]
    mean = np.exp(np.mean(np.log(values)))
    return float(mean / np.sqrt(len(data.positions)))


def distance_slopes(
    model: ExtendedModel, x: np.ndarray, q: np.ndarray, torque: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return distances between pairs of ball positions, shape (N,), and derivatives (N, size).

    Joint positions q have shape (2 N, m) [rad], rows 0 and 1, 2 and 3, ... being pairs, and what
    holds their joints (2 N, 3 m) [N m].
    """
    points, J, _ = model.linearise(x, q, torque)
    offsets = points[1::2] - points[::2]
    distances: np.ndarray = np.linalg.norm(offsets, axis=1).clip(1e-12)
    directions = offsets / distances[:, None]
    return distances, np.einsum("ni,nij->nj", directions, J[1::2] - J[::2])


def distance_deviations(
    posterior: Posterior, q: np.ndarray, torque: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of :func:`distance_slopes`, and their standard deviations [m]."""
    distances, slopes = distance_slopes(posterior.model, posterior.x, q, torque)
    variances = np.sum((slopes @ covariance_of(posterior)) * slopes, axis=1)
    return distances, np.sqrt(variances)


@lru_cache(maxsize=1)  # it takes a while
def covariance_of(posterior: Posterior) -> np.ndarray:
    """Return the covariance of the model's unknowns; play moves samples of servos together."""
    if any(effect.zeros for effect in posterior.model.effects):
        return with_correlated_errors(posterior)
    return posterior.of_unknowns


def predicted_deviation(
    posterior: Posterior, by_socket: Sequence[SocketSamples]
) -> float:
    """Return how far samples should lie from their socket's mean, noise included, as rms [m].

    With J_i the derivatives of n samples, N_i their noise and Jm the mean of J_i, the squares of a
    socket sum to

        sum_i tr J_i Sigma J_i^T - n tr Jm Sigma Jm^T + (1 - 1 / n) sum_i tr N_i
    """
    covariance = posterior.of_unknowns
    total = 0.0
    count = 0
    for q, torque in by_socket:
        sums = np.zeros((3, len(covariance)))
        noise = 0.0
        for begin in range(0, len(q), BATCH):
            some = slice(begin, begin + BATCH)
            _, J, by_joints = posterior.linearise(q[some], torque[some])
            sums += J.sum(axis=0)
            noise += float(np.einsum("nii->", posterior.noise.as_gaussian(by_joints)))
            for slopes in J:
                total += sum_of_variances(slopes, covariance)
        total -= sum_of_variances(sums, covariance) / len(q)
        total += noise * (1 - 1 / len(q))
        count += len(q)
    return (total / count) ** 0.5


def sum_of_variances(rows: np.ndarray, covariance: np.ndarray) -> float:
    """Return the sum of r^T Sigma r of rows r, shape (N, n).

    Columns that are zero in all rows are left out: of a curve, a sample has but four coefficients.
    """
    columns = np.flatnonzero(rows.any(axis=0))
    few = rows[:, columns]
    return float(np.sum((few @ submatrix(covariance, columns)) * few))


def scale(posterior: Posterior) -> Scale:
    """Return by how much the arm came out larger than its model.

    A real arm is within some 0.003 of its model; one that came out beyond had most likely a wrong
    distance between its sockets.
    """
    slope = posterior.model.by_scale()
    variance = float(slope @ covariance_of(posterior) @ slope)
    return Scale(value=float(slope @ posterior.x), deviation=variance**0.5)
