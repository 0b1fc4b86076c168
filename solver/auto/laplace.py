"""Laplace's approximation: the posterior as a bell curve around the best unknowns.

The curvature H of the objective at its minimum says how sharp the best fit is: its inverse is the
covariance of the unknowns. The same curvature gives the evidence, the probability of the data
averaged over all values that the prior allows. It grows with the fit and falls with every unknown
that the fit does not need, so models of different size can be compared by it. docs/model.md
introduces prior, posterior and evidence.
"""

from dataclasses import replace
from math import erfc, lgamma, log, pi, sqrt

import numpy as np

from .deflection import ELASTICITY
from .noise import NU
from .normal_equations import NormalEquations, normal_equations, value
from .objective import Objective, State, free_unknowns, prior_precision, priors
from .posterior import Posterior, World
from .priors import TYPICAL_SPREAD

__all__ = ["inverse", "posterior"]


def posterior(objective: Objective, state: State, iterates: list[np.ndarray]) -> World:
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
    weights = normal.weights * NU / (NU + 3)
    evidence = _log_evidence(objective, state, normal)
    arms = tuple(
        _of_arm(objective, state, i, covariance, weights, evidence, iterates)
        for i in range(len(objective.model.models))
    )
    poses = dict(zip(objective.rows.scene.arms[0].frames, state.frames, strict=True))
    return World(arms, objective.model.own, objective.rows.scene, poses, covariance, evidence)


def _of_arm(
    objective: Objective,
    state: State,
    robot: int,
    covariance: np.ndarray,
    weights: np.ndarray,
    evidence: float,
    iterates: list[np.ndarray],
) -> Posterior:
    """Return what is known of one of the robots."""
    own, rows = objective.model.own[robot], objective.rows.own[robot]
    picked = np.r_[own, objective.dense : objective.size]
    mine = [g for g in state.groups if ((g.members >= own.start) & (g.members < own.stop)).all()]
    noises = {
        bool(objective.rows.sockets[source][0] < 0): noise
        for source, noise in zip(objective.rows.sources, state.noises, strict=True)
        if np.isin(np.arange(len(weights))[source][0], np.arange(len(weights))[rows])
    }
    base = objective.rows.base(robot, state.frames)
    centres = state.centres if base is None else base.inverse().apply(state.centres)
    return Posterior(
        objective.model.models[robot],
        objective.rows.scene.arms[robot],
        state.x[own],
        centres,
        covariance[np.ix_(picked, picked)],
        tuple(replace(g, members=g.members - own.start) for g in mine),
        noises.get(False) or noises[True],
        state.linear.points[rows],
        weights[rows],
        evidence,
        tuple(x[own] for x in iterates),
        noises.get(True),
    )


def _log_evidence(objective: Objective, state: State, normal: NormalEquations) -> float:
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
        if group.typical:
            result -= 0.5 * (log(group.width / group.typical) / TYPICAL_SPREAD) ** 2
    free = free_unknowns(objective, state)
    hessian = normal.information + prior_precision(objective, state)
    result -= 0.5 * float(np.linalg.slogdet(hessian[np.ix_(free, free)])[1])
    return result + _within_bounds(objective, state, normal, inverse(hessian, free))


def _within_bounds(
    objective: Objective, state: State, normal: NormalEquations, covariance: np.ndarray
) -> float:
    """Return what (A6) gains or loses because elasticity is never negative.

    Its prior is the positive half of a bell curve, twice as high as the whole. Of a coefficient x
    that is not zero, the half of the posterior above zero counts, Phi(x / sigma) of it; of one that
    is held at zero, the tail of

        2 N(x; 0, s) exp(-slope x - curvature x^2 / 2)        for x >= 0
    """
    result = 0.0
    for group in state.groups:
        if group.name not in ELASTICITY or not group.width:
            continue
        for i in group.members.tolist():
            if not state.at_zero[i]:
                result += log(erfc(-float(state.x[i]) / covariance[i, i] ** 0.5 / sqrt(2)))
                continue
            row = normal.information[i]
            curvature = row[i] + 1 / group.width**2 - float(row @ covariance @ row)
            slope = float(normal.gradient[i] + state.linear.by_volume[i])
            a = max(slope, 0.0) / sqrt(curvature)
            tail = log(erfc(a / sqrt(2))) + a**2 / 2 if a < 30 else -log(a * sqrt(pi / 2))
            result += tail - log(group.width * sqrt(curvature))
    return result


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
