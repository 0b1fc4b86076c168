"""Joint error curves given everything else, and both together, at given scales."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...data import Observations, Pose
from ..model import scaled_inverse, submatrix
from .curve_marginal import CurveFit
from .curve_prior import CurvePrior, add_blocks
from .linear_samples import samples_around
from .objective import Objective, linearise
from .posterior import Posterior
from .state import State

MOST_SAMPLES = 300
"""Of which the evidence is worked out, and with which the curves are fitted without any basis."""
BATCH = 1000
"""Samples whose part of the normal equations is added at once."""


@dataclass(frozen=True)
class GivenRest:
    """Coefficients e of all curves, Gaussian given y: by M, or of many samples by splines."""

    information: np.ndarray
    """[G, a]^T M^-1 [G, a], shape (d + 1, d + 1)."""
    gain: np.ndarray
    """The mean of e by [y, 1], shape (coefficients, d + 1)."""
    covariance: Callable[[], np.ndarray]
    """Function that returns the covariance of e, which takes a while."""


def given_rest(fit: CurveFit) -> GivenRest:
    """Return the curves by what a fit's samples tell."""
    if len(fit.weights) <= MOST_SAMPLES:
        gain = -fit.prior.times(fit.samples.basis.T @ fit.solved)
        return GivenRest(fit.information, gain, partial(_by_marginal, fit))
    columns = fit.columns.reshape(3 * len(fit.columns), -1)
    weighted = fit.weights[:, None, None] * np.linalg.inv(fit.scales)
    curvature, across = _normal_equations(fit, weighted)
    add_blocks(curvature, fit.prior.inverse)
    gain = -np.linalg.solve(curvature, across)
    weighted_columns = (weighted @ fit.columns).reshape(columns.shape)
    information = columns.T @ weighted_columns + across.T @ gain
    return GivenRest(information, gain, partial(scaled_inverse, curvature))


def _by_marginal(fit: CurveFit) -> np.ndarray:
    """Return the covariance of e given y by M, shape (coefficients, coefficients)."""
    across = fit.prior.times(fit.samples.basis.T)
    covariance = -(across @ fit.inverse[0]) @ across.T
    add_blocks(covariance, fit.prior.block)
    return covariance


def with_curves(
    fit: CurveFit, remainder: GivenRest, covariance: np.ndarray
) -> np.ndarray:
    """Return the covariance of y, then of all curves, by that of y, shape (d, d)."""
    gain = (remainder.gain + fit.shift)[:, : len(covariance)]
    across = gain @ covariance
    of_curves = remainder.covariance() + across @ gain.T
    return np.block([[covariance, across.T], [across, of_curves]])


def _normal_equations(
    fit: CurveFit, weighted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return F^T W F and F^T W [G, a] of the coefficients of all curves."""
    samples, size = fit.samples, len(fit.shift)
    (places, basis), m = samples.places, samples.readings.shape[1]
    curvature = np.zeros(size * size)
    across = np.zeros((size, fit.columns.shape[2]))
    for begin in range(0, len(places), BATCH):
        batch = slice(begin, begin + BATCH)
        index = places[batch].reshape(-1, 4 * m)
        slopes = samples.slopes[batch][..., None] * basis[batch][:, None]
        F = slopes.reshape(-1, 3, 4 * m)
        FW = F.swapaxes(1, 2) @ weighted[batch]
        np.add.at(across, index, FW @ fit.columns[batch])
        pairs = index[:, :, None] * size + index[:, None]
        curvature += np.bincount(pairs.ravel(), (FW @ F).ravel(), size * size)
    return curvature.reshape(size, size), across


def restored_covariance(
    result: Posterior,
    data: Observations,
    frames: tuple[Pose, ...],
    scales: tuple[float, float],
) -> np.ndarray:
    """Return the covariance of a robot's unknowns and sockets from that of all but its curves.

    That is the covariance of what the data tell, frames between unknowns and sockets. Scales
    are amplitude and length of the curves [rad], zero without any.
    """
    model, size, of_rest = result.model, result.model.scalars, result.covariance
    x, d, curves = result.x[:size], len(of_rest), result.deflection.curves
    sockets = np.arange(d - result.centres.size, d)
    if curves is None:
        return submatrix(of_rest, np.append(np.arange(size), sockets))
    rigid = model.without_curves
    objective = Objective(rigid, (), data)
    noises = tuple(result.noises[kind] for kind in data.source_kinds)
    linear = linearise(objective, x, frames)
    state = State(objective, x, result.centres, frames, (), noises, x != x, linear)
    samples = samples_around(state, data, curves)
    nu = state.degrees
    effective = result.weights * (nu + 3) ** 2 / (nu * (nu + 5))
    fit = CurveFit(*samples, CurvePrior(*scales), effective)
    joint = with_curves(fit, given_rest(fit), of_rest)
    return submatrix(joint, np.r_[:size, d : len(joint), sockets])
