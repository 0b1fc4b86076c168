"""Scales of joint error curves and of the noise beside them, by the evidence; and their promise."""

from dataclasses import replace

import numpy as np

from ..identification.inference import (
    Solution,
    bounds_of,
    log_evidence_of_scales,
    updated_groups,
    with_tails,
    without_negligible,
)
from ..identification.model import Noise, information_of, log_determinant, submatrix
from .curve_fit import CurveFit
from .curve_prior import CurvePrior

SHORTEST, LONGEST = 0.02, 0.2
"""Bounds of the curves' length [rad]."""
STEPS = 30
SETTLED = 0.1
"""Relative change of the scales at which they are found: by a step of Newton, to some 1 %."""
LARGEST_STEP = 1.0
"""Of the logarithm of a scale's square."""
DAMPING, LEAST_INFORMATION = 1e-3, 1e-9
"""Added to the information of the scales, as a share of it, and where they show nothing."""
DECIDED = 0.5
"""Number of unknowns that the data decide from which on a group's width is to settle."""


def log_evidence(fit: CurveFit) -> float:
    """Return the logarithm of the evidence of a fit but for a constant, as in (A6)."""
    state, nu, p = fit.state, fit.degrees, fit.pulls
    y, rest = fit.solution.change, fit.rest
    effective = information_of(fit.weights, nu)
    sharp = replace(fit, weights=effective)
    Sigma = sharp.solution.covariance
    P = state.prior_precision()
    log_determinants = np.linalg.slogdet(sharp.blocks)[1]
    log_kernels = (nu + 3) * np.log1p(fit.squares / nu)
    total = log_evidence_of_scales(state, fit.samples.sources)
    total += bounds_of(state, Solution(y, Sigma)).log_share
    total += 0.5 * log_determinant(submatrix(Sigma, state.free))
    total -= 0.5 * float(log_determinants.sum())
    total -= 1.5 * float(np.sum(np.log(effective)))
    total -= 0.5 * float(np.sum(log_kernels))
    total -= 0.5 * float(y @ rest.H @ y)
    total -= float(rest.g @ y)
    total -= 0.5 * float(state.offset @ P @ state.offset)
    if fit.curves:
        total -= 0.5 * float(p @ fit.curves[0] @ p)
    return total


def marginalised(fit: CurveFit) -> CurveFit:
    """Return the fit at the scales of highest evidence."""
    samples = fit.samples
    for _ in range(STEPS):
        state, weights = fit.state, fit.next_weights
        by_weights = 0.2 * float(np.abs(np.log(weights / fit.weights)).max())
        by_scales, prior, noises = _updated_scales(fit)
        y, covariance = fit.solution
        x = state.x + y[: len(state.x)]
        groups, by_groups = updated_groups(
            state,
            x,
            covariance,
            lambda group: group.effective > DECIDED,
        )
        if max(by_weights, by_scales, by_groups) < SETTLED:
            break
        V, C = fit.projected_blocks, fit.scales
        traces: np.ndarray = np.einsum("nij,nji->n", V, C)
        freedom = traces / fit.weights / 3
        noises = without_negligible(noises, samples.sources, samples.slopes)
        noises = with_tails(noises, samples.sources, fit.squares, freedom)
        state = replace(state, groups=groups, noises=noises)
        fit = replace(fit, state=state, prior=prior, weights=weights)
    return fit


def _updated_scales(fit: CurveFit) -> tuple[float, CurvePrior, list[Noise]]:
    """Return the largest relative change, and curves and noises after a step."""
    noises, prior = fit.state.noises, fit.prior
    step = _scale_step(fit) / 2
    changes = np.abs(step)
    factors: list[float] = np.exp(step).tolist()
    if fit.has_process:
        length = prior.length * factors[-1] ** 2
        length = min(max(length, SHORTEST), LONGEST)
        changes[-1] = abs(np.log(length / prior.length))
        amplitude = prior.amplitude * factors[-2]
        prior = CurvePrior(amplitude, length)
    pairs = zip(noises, factors[::2], factors[1::2], strict=False)
    updated = [
        replace(noise, space=noise.space * s, joint=noise.joint * j)
        for noise, s, j in pairs
    ]
    return float(changes.max()), prior, updated


def _scale_step(fit: CurveFit) -> np.ndarray:
    """Return the step of the logarithm of each scale's square by average information.

    With M_a the slope of M by it, the step is I^-1 g, where

        g_a = (p^T M_a p - tr(V M_a)) / 2        I_ab = p^T M_a V M_b p / 2

    Scales are those of each source's seat and joints, then amplitude and length of the curves.
    """
    p = fit.pulls
    of_curves = fit.curves if fit.has_process else ()
    by_sample = p.reshape(-1, 3, 1)
    V, V_blocks = fit.projection, fit.projected_blocks
    slopes = [(part @ by_sample).ravel() for part in fit.parts_of_noise]
    slopes += [part @ p for part in of_curves]
    traces = [np.vdot(V_blocks, part) for part in fit.parts_of_noise]
    traces += [np.vdot(V, part) for part in of_curves]
    U = np.array(slopes)
    gradient = 0.5 * (U @ p - traces)
    information = 0.5 * U @ V @ U.T
    damping = DAMPING * np.diag(information) + LEAST_INFORMATION
    information += np.diag(damping)
    step = np.linalg.solve(information, gradient)
    return step.clip(-LARGEST_STEP, LARGEST_STEP)


LENGTHS = np.geomspace(SHORTEST, LONGEST, 3)
"""Lengths that are tried [rad]; curves of those between are much like both neighbours."""


def promised_gain(flat: CurveFit) -> float:
    """Return how far curves would raise the logarithm of the evidence, about; below 0 for none.

    A fit with curves takes an inverse of M a step, and this a product a length. At no curves, and
    at the noise of highest evidence, the evidence has the slope T by the square of the amplitude,

        T = (p^T K p - tr(V K)) / 2        I_ab = tr(V K_a V K_b) / 2

    with p and V of the fit, K the curves' part of M at amplitude 1, and I the information of K and
    of each part of the noise. Beside the noise, K keeps 1 / (I^-1)_00 of it (Rao's test of scores).
    """
    V, p = flat.projection, flat.pulls
    parts = [part for part in flat.parts_of_noise if part.any()]
    by_noise = [_times_blocks(V, part) for part in parts]
    gains: list[float] = []
    for length in LENGTHS.tolist():
        curved = replace(flat, prior=CurvePrior(1.0, length))
        K = curved.curves[0]
        VK = V @ K
        square = p @ K @ p
        T = 0.5 * float(square - np.trace(VK))
        products = [VK, *by_noise]
        traces: np.ndarray = np.einsum("aij,bji->ab", products, products)
        inverse = np.linalg.inv(0.5 * traces)
        variance = float(inverse[0, 0])
        gains.append(0.5 * T * abs(T) * variance)
    return max(gains)


def _times_blocks(V: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    """Return the product of V, shape (3 N, 3 N), with a matrix of diagonal blocks, (N, 3, 3)."""
    columns = V.reshape(len(V), -1, 3).swapaxes(0, 1)
    return (columns @ blocks).swapaxes(0, 1).reshape(V.shape)
