"""The evidence of a movement about a result without it, from one step of the fit."""

from dataclasses import replace

import numpy as np

from ..model import Movement
from .linear_samples import resumed
from .normal_equations import normal_equations
from .objective import build_objective, free_unknowns, prior_precision
from .posterior import JointPosterior


def movement_gain(found: JointPosterior, movement: Movement) -> float:
    """Return the rise of the logarithm of the evidence by a further movement, to first order.

    With g the slope of L by its unknowns u, P their prior's precision and S their covariance beside
    all other unknowns, it is (g^T S g + log |S| + log |P|) / 2.
    """
    models = [arm.model for arm in found.arms]
    prior = (movement, np.zeros(movement.size), movement.prior(0))
    both = replace(found, movements=(*found.movements, prior))
    objective = build_objective(models, found.scene, [one for one, _, _ in both.movements])
    state = resumed(both, objective)
    normal = normal_equations(objective, state)
    hessian = normal.information.plus(prior_precision(objective, state))
    covariance = hessian.inverse(free_unknowns(objective, state)[: objective.dense]).dense
    end = objective.model.size
    own = slice(end - movement.size, end)
    S, g = covariance[own, own], normal.gradient[own]
    logs = np.linalg.slogdet(S)[1] + np.linalg.slogdet(prior[2].precision(prior[2].width))[1]
    return 0.5 * float(g @ S @ g + logs)
