"""Joint error curves given everything else, and both together, at given scales."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from ..identification.data import Observations, Pose
from ..identification.inference import Objective, Posterior, State, linearise
from ..identification.model import information_of, scaled_inverse, submatrix
from .curve_fit import CurveFit
from .curve_prior import CurvePrior, add_blocks
from .linear_samples import samples_around

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
        pulls = fit.samples.basis.T @ fit.solved
        gain = -fit.prior.times(pulls)
        return GivenRest(fit.information, gain, partial(_by_marginal, fit))
    w = fit.weights[:, None, None]
    W = w * np.linalg.inv(fit.scales)
    curvature, across = _normal_equations(fit, W)
    add_blocks(curvature, fit.prior.inverse)
    gain = -np.linalg.solve(curvature, across)
    columns = fit.columns.reshape(3 * len(W), -1)
    weighted = (W @ fit.columns).reshape(columns.shape)
    information = columns.T @ weighted + across.T @ gain
    return GivenRest(information, gain, partial(scaled_inverse, curvature))


def _by_marginal(fit: CurveFit) -> np.ndarray:
    """Return the covariance of e given y by M, shape (coefficients, coefficients)."""
    across = fit.prior.times(fit.samples.basis.T)
    M_inverse = fit.inverse[0]
    covariance = -(across @ M_inverse) @ across.T
    add_blocks(covariance, fit.prior.block)
    return covariance


def covariance_with_curves(
    fit: CurveFit,
    curves: GivenRest,
    covariance: np.ndarray,
) -> np.ndarray:
    """Return the covariance of y, then of all curves, by that of y, shape (d, d)."""
    gain = curves.gain + fit.shift
    gain = gain[:, : len(covariance)]
    across = gain @ covariance
    of_curves = curves.covariance() + across @ gain.T
    of_rest = [covariance, across.T]
    return np.block([of_rest, [across, of_curves]])


def _normal_equations(fit: CurveFit, W: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return F^T W F and F^T W [G, a] of the coefficients of all curves; W is (N, 3, 3)."""
    samples, size = fit.samples, len(fit.shift)
    coefficients, weights = samples.coefficients
    N, m, _ = coefficients.shape
    curvature = np.zeros(size * size)
    across = np.zeros((size, fit.columns.shape[2]))
    for begin in range(0, N, BATCH):
        batch = slice(begin, begin + BATCH)
        index = coefficients[batch].reshape(-1, 4 * m)
        S = samples.slopes[batch][..., None]
        basis = S * weights[batch][:, None]
        F = basis.reshape(-1, 3, 4 * m)
        FW = F.swapaxes(1, 2) @ W[batch]
        np.add.at(across, index, FW @ fit.columns[batch])
        pairs = index[:, :, None] * size + index[:, None]
        FWF = FW @ F
        curvature += np.bincount(pairs.ravel(), FWF.ravel(), size * size)
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
    of_rest, curves = result.covariance, result.deflection.curves
    d, size = len(of_rest), result.model.scalars
    sockets = np.arange(d - result.centres.size, d)
    if curves is None:
        rows = np.r_[:size, sockets]
        return submatrix(of_rest, rows)
    x = result.x[:size]
    objective = Objective(result.model.without_curves, (), data)
    noises = tuple(result.noises[kind] for kind in data.source_kinds)
    state = State(
        objective=objective,
        x=x,
        centres=result.centres,
        frames=frames,
        groups=(),
        noises=noises,
        at_zero=np.zeros(size, dtype=bool),
        linear=linearise(objective, x, frames),
    )
    nu = state.degrees
    weights = result.weights * (nu + 3) / nu
    state, samples = samples_around(state, data, curves)
    information = information_of(weights, nu)
    fit = CurveFit(state, samples, CurvePrior(*scales), information)
    of_all = covariance_with_curves(fit, given_rest(fit), of_rest)
    rows = np.r_[:size, d : len(of_all), sockets]
    return submatrix(of_all, rows)
