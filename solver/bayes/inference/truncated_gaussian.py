"""The Gaussian most like one that is cut off at zero, by expectation propagation (Minka 2001)."""

from dataclasses import dataclass
from math import erfc, log, pi, sqrt

import numpy as np

SWEEPS = 200
DAMPING = 0.5
SETTLED = 1e-6


@dataclass(frozen=True)
class TruncatedGaussian:
    """Gaussian factors that replace the bounds, and the share of the Gaussian within them."""

    precision: np.ndarray
    """tau of each unknown, shape (b,)."""
    pull: np.ndarray
    """nu, shape (b,)."""
    log_share: float
    """Logarithm of the share of the Gaussian that is within all bounds."""


def expectation_propagation(mean: np.ndarray, covariance: np.ndarray) -> TruncatedGaussian:
    """Return factors that stand for x >= 0."""
    unit = np.sqrt(np.diag(covariance))  # unknowns in units of their own deviation
    S, m = covariance / np.outer(unit, unit), mean / unit
    P = np.linalg.inv(S)
    h = P @ m
    tau, nu = np.zeros(len(m)), np.zeros(len(m))
    free, pull, log_half = tau, nu, tau
    for _ in range(SWEEPS):
        now = np.linalg.inv(P + np.diag(tau))
        centre, variance = now @ (h + nu), np.diag(now)
        free, pull = 1 / variance - tau, centre / variance - nu  # without its own factor
        z = pull / np.sqrt(free)
        hazard, excess, log_half = _half(z)
        wanted = free / (1 - hazard * excess)  # 1 / variance with the bound
        change = np.array([wanted - free - tau, wanted * excess / np.sqrt(free) - pull - nu])
        tau, nu = tau + DAMPING * change[0], nu + DAMPING * change[1]
        if np.abs(change).max() < SETTLED * (1 + np.abs([tau, nu]).max()):
            break
    now = np.linalg.inv(P + np.diag(tau))
    share = 0.5 * float((h + nu) @ now @ (h + nu) - m @ h)
    share -= 0.5 * float(np.linalg.slogdet(np.eye(len(m)) + S * tau)[1])
    share += float(np.sum(log_half + 0.5 * np.log1p(tau / free)))
    share -= 0.5 * float(np.sum((pull + nu) ** 2 / (free + tau) - pull**2 / free))
    return TruncatedGaussian(tau / unit**2, nu / unit, share)


def _half(z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return figures of a standard Gaussian around z of which only x >= 0 is left."""
    hazard, excess, log_half = np.empty(len(z)), np.empty(len(z)), np.empty(len(z))
    for i, one in enumerate(z.tolist()):
        density = -0.5 * one**2 - 0.5 * log(2 * pi)
        if one > -5:
            half = 0.5 * erfc(-one / sqrt(2))
            hazard[i] = np.exp(density) / half
            excess[i] = one + hazard[i]
            log_half[i] = log(half)
        else:  # Laplace's continued fraction, where rounding would leave nothing
            rest = -one
            for k in range(40, 1, -1):
                rest = -one + k / rest
            excess[i] = 1 / rest
            hazard[i] = excess[i] - one
            log_half[i] = density - log(hazard[i])
    return hazard, excess, log_half
