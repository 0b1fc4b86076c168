"""Mean and covariance of joint error curves and of everything else, at given scales."""

from collections.abc import Sequence

import numpy as np

from ..model import Noise
from ..model.effects import KNOTS, circulant, spectrum, splines
from .curve_marginal import CurvePrior, curve_covariance, marginal
from .linear_samples import LinearSamples, Rest

JITTER, LEAST = 1e-6, 1e-20
"""Added to a prior's correlations, and the least of its variances, so that it has an inverse."""
BATCH = 1000
"""Samples whose part of the normal equations is added at once."""


def spline_coefficients(samples: LinearSamples, prior: CurvePrior, pulls: np.ndarray) -> np.ndarray:
    """Return the curves that the samples' pulls belong to, shape (robots, m, KNOTS) [rad]."""
    m = samples.readings.shape[1]
    if samples.given is not None:
        pulled = samples.basis.reshape(pulls.size, -1).T @ pulls.ravel()
        return -(samples.given @ pulled).reshape(1, m, KNOTS)
    index, weights = _places(samples)
    along = np.einsum("nij,ni->nj", samples.slopes, pulls)
    sums = np.bincount(
        index.ravel(), (weights * along[..., None]).ravel(), samples.count * m * KNOTS
    )
    filtered = np.fft.fft(sums.reshape(samples.count, m, KNOTS)) * spectrum(prior.length)
    return -(prior.amplitude**2) * np.fft.ifft(filtered).real


def _places(samples: LinearSamples) -> tuple[np.ndarray, np.ndarray]:
    """Return the four coefficients of each sample and joint among all, and their weights."""
    index, weights = splines(samples.readings)
    m = samples.readings.shape[1]
    first: np.ndarray = (samples.arms[:, None] * m + np.arange(m, dtype=np.int64)) * KNOTS
    return index + first[..., None], weights


def solve(
    samples: LinearSamples,
    noises: Sequence[Noise],
    prior: CurvePrior,
    rest: Rest,
    weights: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the most probable unknowns by the normal equations, for any number of samples."""
    C, nu = samples.scales(noises), samples.degrees(noises)
    inverse, (index, basis) = np.linalg.inv(C), _places(samples)
    H, slope = curvature_of(samples, prior, rest, weights[:, None, None] * inverse)
    solution, d = -np.linalg.solve(H, slope), int(rest.free.sum())
    y, c = np.zeros(len(rest.free)), solution[d:]
    y[rest.free] = solution[:d]
    curves: np.ndarray = np.sum(c[index] * basis, axis=2)
    errors = samples.errors + samples.by_rest @ y + (samples.slopes @ curves[..., None])[..., 0]
    squares: np.ndarray = np.sum(errors * (inverse @ errors[..., None])[..., 0], axis=1)
    shape = samples.count, samples.readings.shape[1], KNOTS
    return y, c.reshape(shape), (nu + 3) / (nu + squares)


def curvature_of(
    samples: LinearSamples, prior: CurvePrior, rest: Rest, weighted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return curvature and slope at y = 0 and no curves, by what of y is free, then by curves."""
    (n, _, m), d = samples.slopes.shape, int(rest.free.sum())
    size = samples.count * m * KNOTS
    H, slope = np.zeros((d + size, d + size)), np.zeros(d + size)
    G, (places, basis) = samples.by_rest[:, :, rest.free], _places(samples)
    WG = (weighted @ G).reshape(-1, d)
    H[:d, :d] = G.reshape(-1, d).T @ WG + rest.precision[np.ix_(rest.free, rest.free)]
    slope[:d] = WG.T @ samples.errors.ravel() + rest.gradient[rest.free]
    curves, flat = np.zeros(size * size), np.zeros((size, d + 1))
    for begin in range(0, n, BATCH):
        some = slice(begin, begin + BATCH)
        index = places[some].reshape(-1, 4 * m)
        F = (samples.slopes[some][..., None] * basis[some][:, None]).reshape(-1, 3, 4 * m)
        WF = weighted[some] @ F
        across = np.concatenate([G[some], samples.errors[some][..., None]], axis=2)
        np.add.at(flat, index, WF.swapaxes(1, 2) @ across)
        pairs = index[:, :, None] * size + index[:, None]
        curves += np.bincount(pairs.ravel(), (F.swapaxes(1, 2) @ WF).ravel(), size * size)
    H[d:, d:] = curves.reshape(size, size)
    H[d:, :d], H[:d, d:], slope[d:] = flat[:, :d], flat[:, :d].T, flat[:, d]
    if samples.given is not None:
        unit = 1 / np.sqrt(np.diag(samples.given).clip(min=LEAST))
        inverse = np.linalg.inv(samples.given * unit[:, None] * unit + JITTER * np.eye(size))
        H[d:, d:] += inverse * unit[:, None] * unit
        return H, slope
    own = circulant(1 / spectrum(prior.length)) / prior.amplitude**2
    for begin in range(d, d + size, KNOTS):
        H[begin : begin + KNOTS, begin : begin + KNOTS] += own
    return H, slope


def covariance(
    samples: LinearSamples,
    noises: Sequence[Noise],
    prior: CurvePrior,
    rest: Rest,
    weights: np.ndarray,
    *,
    by_splines: bool,
) -> np.ndarray:
    """Return the covariance of y, then of all curves' coefficients."""
    C, nu = samples.scales(noises), samples.degrees(noises)
    told = weights * (nu + 3) / (nu + 5)
    if by_splines:
        return _by_splines(samples, prior, rest, told[:, None, None] * np.linalg.inv(C))
    curves = curve_covariance(samples, prior)
    found = marginal(samples, curves, C / told[:, None, None], rest)
    d, free = len(rest.free), found.free
    half, own = _with_samples(samples, prior, found.root)
    end = d + half.shape[1]
    shown = found.root @ samples.by_rest.reshape(len(half), d)[:, free]
    whole, across = np.empty((end, end)), np.zeros((end - d, d))
    across[:, free] = -half.T @ (shown @ found.covariance[np.ix_(free, free)])
    whole[:d, :d], whole[d:, :d], whole[:d, d:] = found.covariance, across, across.T
    # What the rest explains is taken out of L^-1 B^T, for one product in place of two.
    u, s, _ = np.linalg.svd(
        shown @ np.linalg.cholesky(found.covariance[np.ix_(free, free)]), full_matrices=False
    )
    half -= (u * (1 - np.sqrt((1 - s**2).clip(min=0)))) @ (u.T @ half)
    curves = np.matmul(half.T, half, out=whole[d:, d:])
    np.negative(curves, out=curves)
    for begin in range(0, end - d, len(own)):
        curves[begin : begin + len(own), begin : begin + len(own)] += own
    return whole


def _with_samples(
    samples: LinearSamples, prior: CurvePrior, root: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return L^-1 B^T, shape (3 N, robots m KNOTS), and the prior of a joint or of all at once.

    B is the covariance of the curves with the samples' errors.
    """
    n, m = samples.readings.shape
    if samples.given is not None:
        return root @ (samples.basis.reshape(3 * n, -1) @ samples.given), samples.given
    own = prior.amplitude**2 * circulant(spectrum(prior.length))
    index, basis = splines(samples.readings)
    found = np.zeros((3 * n, samples.count, m, KNOTS))
    for j in range(m):
        with_readings = (own[index[:, j]] * basis[:, j, :, None]).sum(axis=1)
        along = np.einsum("kna,na->kn", root.reshape(3 * n, n, 3), samples.slopes[:, :, j])
        for arm in range(samples.count):
            rows = samples.arms == arm
            found[:, arm, j] = along[:, rows] @ with_readings[rows]
    return found.reshape(3 * n, -1), own


def _by_splines(
    samples: LinearSamples, prior: CurvePrior, rest: Rest, weighted: np.ndarray
) -> np.ndarray:
    H, _ = curvature_of(samples, prior, rest, weighted)
    unit = 1 / np.sqrt(np.diag(H))
    inverse = np.linalg.inv(H * unit[:, None] * unit)
    inverse *= unit[:, None]
    inverse *= unit
    d = len(rest.free)
    kept = np.r_[np.flatnonzero(rest.free), d : d + len(H) - int(rest.free.sum())]
    whole = np.zeros((kept[-1] + 1,) * 2)
    whole[np.ix_(kept, kept)] = inverse
    return whole
