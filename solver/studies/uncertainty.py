"""Uncertainty of a calibration: standard deviations, correlations, predicted errors."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..identification.data import IDENTITY, Samples
from ..identification.inference import Posterior
from ..identification.model import ExtendedModel, extend, submatrix
from ..results import Correlation, Fit, Measurements, Scale, Study
from .projections import (
    basis_of,
    outside,
    pair_lengths,
    rows_of,
    unit,
    variances_of,
)
from .whitening import with_correlated_errors

UNDECIDED = 0.5
"""The data did not decide a direction if its posterior is wider than this share of its prior."""
STRONG = 0.9
"""Correlations of two unknowns beyond this are reported."""
BATCH = 500
"""Samples whose derivatives by all unknowns are held at once."""


def correlations(posterior: Posterior) -> tuple[Correlation, ...]:
    """Return unknowns correlated beyond :data:`STRONG`, the closest pair first."""
    size = posterior.model.scalars
    deviation = np.sqrt(np.diag(posterior.covariance)[:size])
    prior = np.sqrt(np.diag(posterior.prior_covariance))
    is_decided = (deviation > 0) & (deviation < UNDECIDED * prior)
    decided = np.flatnonzero(is_decided)
    deviation = deviation[decided]
    covariance = submatrix(posterior.covariance, decided)
    matrix = covariance / np.outer(deviation, deviation)
    is_strong = np.abs(matrix) > STRONG
    names = [posterior.model.names[i] for i in decided]
    pairs = [
        Correlation(names[i], names[j], float(matrix[i, j]))
        for i, j in np.argwhere(np.triu(is_strong, k=1)).tolist()
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
    q = posterior.deflection.true_positions(data)
    linear = model.ball.linearise(posterior.values, q)
    variances = np.diag(posterior.prior_covariance)
    widths = np.sqrt(variances[: model.geometry])
    scaled = linear.by_parameters * widths
    motions = IDENTITY.slopes(linear.points)
    shifts = motions[:, :, 3:]
    places = [(data.sockets == k, shifts) for k in range(data.socket_count)]
    places += [(data.measured_in == k, motions) for k in range(len(data.frames))]
    centred = [
        outside(rows_of(scaled[rows]), basis_of(changes[rows]))
        for rows, changes in places
        if rows.any()
    ]
    slopes = np.concatenate(centred)
    values = np.linalg.svd(slopes, compute_uv=False)
    log_mean = np.mean(np.log(values[values > 1e-6 * values[0]]))
    return float(np.exp(log_mean)) / len(data.q) ** 0.5


def distance_slopes(
    model: ExtendedModel,
    x: np.ndarray,
    samples: Samples,
) -> tuple[np.ndarray, np.ndarray]:
    """Return distances between pairs of ball positions, shape (N,), and derivatives (N, size).

    Of the 2 N samples, rows 0 and 1, 2 and 3, ... are pairs.
    """
    points, J, _ = model.linearise(x, samples)
    directions = unit(points[1::2] - points[::2])
    slopes = np.einsum("ni,nij->nj", directions, J[1::2] - J[::2])
    return pair_lengths(points), slopes


def distance_deviations(
    posterior: Posterior,
    samples: Samples,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distances of :func:`distance_slopes`, and their standard deviations [m]."""
    distances, slopes = distance_slopes(posterior.model, posterior.x, samples)
    variances = variances_of(slopes, covariance_of(posterior))
    return distances, np.sqrt(variances)


@lru_cache(maxsize=1)  # it takes a while
def covariance_of(posterior: Posterior) -> np.ndarray:
    """Return the covariance of the model's unknowns; play moves seated samples of servos alike."""
    of_servos = any(effect.zeros for effect in posterior.model.effects)
    if of_servos and posterior.data.seated.any():
        return with_correlated_errors(posterior)
    return posterior.of_unknowns


def predicted_deviation(
    posterior: Posterior,
    by_socket: Sequence[Samples],
) -> float:
    """Return how far samples should lie from their socket's mean, noise included, as rms [m].

    With J_i the derivatives of n samples, N_i their noise and Jm the mean of J_i, the squares of a
    socket sum to

        sum_i tr J_i Sigma J_i^T - n tr Jm Sigma Jm^T + (1 - 1 / n) sum_i tr N_i
    """
    total = sum(_sum_of_squares(posterior, samples) for samples in by_socket)
    count = sum(len(samples.q) for samples in by_socket)
    return (total / count) ** 0.5


def _sum_of_squares(
    posterior: Posterior,
    samples: Samples,
) -> float:
    """Return the sum of squares of n samples in a socket [m^2]."""
    n = len(samples.q)
    covariance = posterior.of_unknowns
    sums = np.zeros((3, len(covariance)))
    total = noise = 0.0
    for begin in range(0, n, BATCH):
        some = slice(begin, begin + BATCH)
        _, J, by_joints = posterior.linearise(samples.only(some))
        sums += J.sum(axis=0)
        N = posterior.noise.as_gaussian(by_joints)
        noise += float(np.einsum("nii->", N))
        for slopes in J:
            total += sum_of_variances(slopes, covariance)
    of_mean = sum_of_variances(sums, covariance) / n
    return total - of_mean + noise * (1 - 1 / n)


def sum_of_variances(
    rows: np.ndarray,
    covariance: np.ndarray,
) -> float:
    """Return the sum of r^T Sigma r of rows r, shape (N, n).

    Columns that are zero in all rows are left out: of a curve, a sample has but four coefficients.
    """
    columns = np.flatnonzero(rows.any(axis=0))
    few = submatrix(covariance, columns)
    variances = variances_of(rows[:, columns], few)
    return float(variances.sum())


def scale(posterior: Posterior) -> Scale:
    """Return by how much the arm came out larger than its model.

    A real arm is within some 0.003 of its model; one that came out beyond had most likely a wrong
    distance between its sockets.
    """
    return _scale(posterior.model, posterior.x, covariance_of(posterior))


def _scale(
    model: ExtendedModel,
    x: np.ndarray,
    covariance: np.ndarray | None,
) -> Scale:
    """Return the same by a model's unknowns; None for a covariance that is not known."""
    slopes = model.by_scale()
    deviation = None
    if covariance is not None:
        deviation = float(slopes @ covariance @ slopes) ** 0.5
    return Scale(value=float(slopes @ x), deviation=deviation)


def model_of(fit: Fit) -> tuple[ExtendedModel, np.ndarray]:
    """Return the model of a fit, and its most probable unknowns, shape (size,)."""
    if fit.posterior is not None:
        return fit.posterior.model, fit.posterior.x
    arm = fit.calibrated
    model = extend(arm.robot, arm.parameters, rotation_numbers=arm.rotation_numbers)
    return model, arm.values - arm.model.nominal


def scale_of(
    fit: Fit,
    _: Measurements,
) -> Scale:
    """Return by how much the arm came out larger than its model."""
    if fit.posterior is not None:
        return scale(fit.posterior)
    return _scale(*model_of(fit), fit.covariance)


SCALE = Study("scale", scale_of, needs_posterior=False)
