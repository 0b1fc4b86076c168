"""Laplace's approximation: the posterior as a Gaussian at its maximum, and the objective.

The evidence is the probability of the data under a model whose unknowns are integrated out. It
grows with the fit and falls with every unknown that the fit does not need, so models of different
size can be compared by it; see docs/model.md.
"""

from math import lgamma, log, pi

import numpy as np

from .noise import NU
from .normal_equations import normal_equations, weigh
from .objective import Objective, State, distance_rows, free_unknowns, prior_precision, priors
from .posterior import Posterior

__all__ = ["inverse", "posterior"]


def posterior(objective: Objective, state: State, iterates: list[np.ndarray]) -> Posterior:
    """Return what is known at a state where the iteration has settled.

    The covariance counts the uncertainty of the priors' widths.

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

    log p(data) = -L + sum_g log|P_g| / 2 - log|H| / 2 + log p(widths)                 (6)
    """
    _, squares, _ = weigh(state)
    N = len(squares)
    scales = np.linalg.slogdet(state.noise.scales(state.linear.by_joints))[1]
    constant = lgamma((NU + 3) / 2) - lgamma(NU / 2) - 1.5 * log(NU * pi)
    value = N * constant - 0.5 * scales.sum() - 0.5 * (NU + 3) * np.log1p(squares / NU).sum()
    value += float(objective.by_volume[: objective.model.size] @ state.x)
    value -= 0.5 * float(np.sum(distance_rows(objective, state)[1] ** 2))
    for group, members in priors(state):
        P = group.precision(members, group.width)
        value += 0.5 * float(np.linalg.slogdet(P)[1] - state.x[members] @ P @ state.x[members])
        value -= 0.5 * (group.width / group.scale) ** 2
    free = free_unknowns(objective, state)
    hessian = (information + prior_precision(objective, state))[np.ix_(free, free)]
    return float(value - 0.5 * np.linalg.slogdet(hessian)[1])


def inverse(H: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the inverse of a positive definite matrix whose rows differ in scale.

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
