"""Bounds x >= 0 of unknowns, each replaced by a Gaussian factor by expectation propagation."""

from functools import partial
from math import erfc, exp, log, pi, sqrt
from typing import NamedTuple

import numpy as np

from ..model import submatrix
from .normal_equations import NormalEquations, Solution
from .state import State

SWEEPS = 200
DAMPING = 0.5
SETTLED = 1e-6


class Factors(NamedTuple):
    """Factors exp(nu x - tau x^2 / 2) in place of bounds x >= 0."""

    precision: np.ndarray
    """tau of each."""
    pull: np.ndarray
    """nu of each."""
    log_share: float
    """Logarithm of the share of the Gaussian that is within the bounds."""


class Bounds(NamedTuple):
    """The factors of all bounds as a part of L, and the share within the bounds."""

    equations: NormalEquations
    log_share: float

    @property
    def any(self) -> bool:
        """True where an unknown is bounded."""
        return bool(self.equations.H.any())


def bounds_of(state: State, solution: Solution) -> Bounds:
    """Return the bounds of a state's unknowns, by the solution without them."""
    b = np.flatnonzero(state.bounded & state.free)
    n = len(solution.change)
    precision, slope = np.zeros((2, n))
    log_share = 0.0
    if len(b):
        x = state.x[b]
        covariance = submatrix(solution.covariance, b)
        factors = expectation_propagation(x + solution.change[b], covariance)
        precision[b] = factors.precision
        slope[b] = factors.precision * x - factors.pull
        log_share = factors.log_share
    return Bounds(NormalEquations(np.diag(precision), slope), log_share)


def expectation_propagation(mean: np.ndarray, covariance: np.ndarray) -> Factors:
    """Return a factor for each bound x >= 0 of some unknowns (Minka 2001).

    Each factor is chosen to give its unknown, beside all other factors (the cavity), the mean and
    the variance that the bound itself gives it.
    """
    unit = np.sqrt(np.diag(covariance))  # unknowns in units of their own deviation
    m = mean / unit
    S = covariance / np.outer(unit, unit)
    P = np.linalg.inv(S)
    h = P @ m
    tau, nu = np.zeros((2, len(m)))
    precision, pull, log_half = tau, nu, tau
    for _ in range(SWEEPS):
        now = np.linalg.inv(P + np.diag(tau))
        variance = np.diag(now)
        centre = now @ (h + nu)
        precision = 1 / variance - tau  # of the cavity
        pull = centre / variance - nu
        deviation = 1 / np.sqrt(precision)
        hazard, excess, log_half = half_moments(pull * deviation)
        target = precision / (1 - hazard * excess)  # 1 / variance with the bound
        by_tau = target - precision - tau
        by_nu = target * excess * deviation - pull - nu
        tau = tau + DAMPING * by_tau
        nu = nu + DAMPING * by_nu
        change = np.abs([by_tau, by_nu]).max()
        size = np.abs([tau, nu]).max()
        if change < SETTLED * (1 + size):
            break
    now = np.linalg.inv(P + np.diag(tau))
    ratios = np.eye(len(m)) + S * tau
    pulls = h + nu
    squares = pulls @ now @ pulls - m @ h
    log_share = 0.5 * (squares - np.linalg.slogdet(ratios)[1])
    after = (pull + nu) ** 2 / (precision + tau)
    before = pull**2 / precision
    log_ratios = np.log1p(tau / precision)
    by_bound = log_half + 0.5 * (log_ratios - after + before)
    log_share += np.sum(by_bound)
    return Factors(tau / unit**2, nu / unit, float(log_share))


@partial(np.vectorize, otypes="ddd")
def half_moments(z: float) -> tuple[float, float, float]:
    """Return hazard, mean and log share of the half x >= 0 of a standard Gaussian around z."""
    log_density = -0.5 * z**2 - 0.5 * log(2 * pi)
    if z > -5:
        share = 0.5 * erfc(-z / sqrt(2))
        hazard = exp(log_density) / share
        return hazard, z + hazard, log(share)
    fraction = -z  # Laplace's continued fraction, where rounding would leave nothing
    for k in range(40, 1, -1):
        fraction = -z + k / fraction
    mean = 1 / fraction
    return mean - z, mean, log_density - log(mean - z)
