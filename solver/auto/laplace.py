"""Laplace's approximation: the posterior as a bell curve around the best unknowns.

The curvature H of the objective at its minimum says how sharp the best fit is: its inverse is the
covariance of the unknowns. The same curvature gives the evidence, the probability of the data
averaged over all values that the prior allows. It grows with the fit and falls with every unknown
that the fit does not need, so models of different size can be compared by it. docs/model.md
introduces prior, posterior and evidence.
"""

from math import lgamma, log, pi

import numpy as np

from .noise import NU
from .normal_equations import normal_equations, value
from .objective import Objective, State, free_unknowns, prior_precision, priors
from .posterior import Posterior

__all__ = ["inverse", "posterior"]


def posterior(objective: Objective, state: State, iterates: list[np.ndarray]) -> Posterior:
    """Return the posterior at a state where the iteration has settled.

    The widths of the priors are estimates, too; their own uncertainty makes the covariance larger.

    Args:
        objective: What was minimised.
        state: At its minimum.
        iterates: x after each iteration.
    """
    normal = normal_equations(objective, state)
    widened = normal.information + prior_precision(objective, state, widened=True)
    covariance = inverse(widened, free_unknowns(objective, state))
    return Posterior(
        objective.model,
        objective.data,
        state.x,
        state.centres,
        covariance,
        state.groups,
        state.noise,
        state.linear.points,
        normal.weights * NU / (NU + 3),
        _log_evidence(objective, state, normal.information),
        tuple(iterates),
    )


def _log_evidence(objective: Objective, state: State, information: np.ndarray) -> float:
    """Return the logarithm of the evidence.

    log p(data) = -L + sum_g log|P_g| / 2 - log|H| / 2 + log p(widths)                 (A6)

    L is the objective (A1), P_g the prior precision of group g, H the curvature (A3), |.| the
    determinant, and p(widths) the prior of the widths themselves.
    """
    constant = lgamma((NU + 3) / 2) - lgamma(NU / 2) - 1.5 * log(NU * pi)
    result = len(state.linear.errors) * constant - value(objective, state)
    for group, members in priors(state):
        P = group.precision(members, group.width)
        result += 0.5 * float(np.linalg.slogdet(P)[1]) - 0.5 * (group.width / group.scale) ** 2
    free = free_unknowns(objective, state)
    hessian = (information + prior_precision(objective, state))[np.ix_(free, free)]
    return float(result - 0.5 * np.linalg.slogdet(hessian)[1])


def inverse(H: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the inverse of a positive definite matrix whose rows have different units.

    Args:
        H: The matrix, shape (n, n).
        free: Which rows and columns count, shape (n,); the others are zero in the inverse.
    """
    part = H[np.ix_(free, free)]
    scale = 1 / np.sqrt(np.diag(part))
    whole = np.zeros_like(H)
    whole[np.ix_(free, free)] = (
        np.linalg.inv(part * scale[:, None] * scale) * scale[:, None] * scale
    )
    return whole
