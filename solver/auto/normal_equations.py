"""Weights, curvature and slope of the data's part of the objective, for a Gauss-Newton step.

A sample's error e_i = Phi(x, q_i) - m_s(i) depends on x and the frames by J_i, shape (3, dense),
and on the centre of its own socket alone, by -I. Nothing of the size of samples times sockets is
ever built, so time and memory grow with the number of samples, however many sockets they are in.
"""

from dataclasses import dataclass

import numpy as np

from .noise import INFORMATION, NU
from .objective import Objective, State, knowledge

__all__ = [
    "NormalEquations",
    "curvature",
    "leverage",
    "normal_equations",
    "predicted_errors",
    "value",
    "weigh",
]


@dataclass(frozen=True)
class NormalEquations:
    """The quadratic approximation of the data's part of the objective L, in all n unknowns."""

    information: np.ndarray
    """Its curvature, shape (n, n)."""
    gradient: np.ndarray
    """Its slope, shape (n,)."""
    inverse_scales: np.ndarray
    """C_i^-1, shape (N, 3, 3) [1/m^2]."""
    known: np.ndarray
    """W (l - d) and the like, see :func:`~mukca.solver.auto.objective.knowledge`."""
    squares: np.ndarray
    """e_i^T C_i^-1 e_i, shape (N,)."""
    weights: np.ndarray
    """w_i, robust weight of each sample, shape (N,)."""


def weigh(objective: Objective, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return C_i^-1, the squared errors relative to the noise, and the robust weights.

        w_i = (nu + 3) / (nu + e_i^T C_i^-1 e_i)                                           (A2)

    A sample whose error is large beside its noise weighs little. With these weights, a weighted
    sum of squares has the same slope as Student's distribution.

    Returns:
        C_i^-1, shape (N, 3, 3) [1/m^2]; e_i^T C_i^-1 e_i, shape (N,); w_i, shape (N,).
    """
    inverse = np.linalg.inv(scales(objective, state))
    e = state.linear.errors
    squares = np.einsum("ni,ni->n", np.einsum("nij,nj->ni", inverse, e), e)
    return inverse, squares, (NU + 3) / (NU + squares)


def scales(objective: Objective, state: State) -> np.ndarray:
    """Return C_i of each sample, by the noise of its source, shape (N, 3, 3) [m^2]."""
    by_joints = state.linear.by_joints
    scales = np.empty((len(by_joints), 3, 3))
    for source, noise in zip(objective.rows.sources, state.noises, strict=True):
        scales[source] = noise.scales(by_joints[source])
    return scales


def value(
    objective: Objective,
    state: State,
    volume: float = 1.0,
    normal: NormalEquations | None = None,
) -> float:
    """Return L of (A1) at a state, but for a constant.

    Args:
        objective: What is minimised.
        state: Where.
        volume: How much of the last term counts.
        normal: The normal equations there, where they are known already.
    """
    if normal is None:
        (inverse, squares, _), known = weigh(objective, state), knowledge(objective, state)[1]
    else:
        inverse, squares, known = normal.inverse_scales, normal.squares, normal.known
    sizes = -np.linalg.slogdet(inverse)[1]
    cost = 0.5 * float(sizes.sum()) + 0.5 * (NU + 3) * float(np.log1p(squares / NU).sum())
    cost += 0.5 * float(np.sum(known**2))
    for group in state.groups:
        if group.width:
            apart = state.x[group.members] - group.mean
            cost += 0.5 * float(apart @ group.precision(group.width) @ apart)
    return cost + volume * state.linear.volume


def normal_equations(objective: Objective, state: State) -> NormalEquations:
    """Return curvature and slope of the samples' and the measured distances' part of L.

    curvature  sum_i k w_i [J_i, -I]^T C_i^-1 [J_i, -I]  +  B^T W^T W B
    slope      sum_i w_i [J_i, -I]^T C_i^-1 e_i          +  B^T W^T W (l - d)

    B is the derivative of the distances l by all unknowns, and k says how much one sample with
    Student's noise tells, relative to one with Gaussian noise.
    """
    inverse, squares, weights = weigh(objective, state)
    weighted = inverse * weights[:, None, None]
    J, size = state.linear.by_unknowns, objective.dense
    We = np.einsum("nij,nj->ni", weighted, state.linear.errors)
    gradient = np.zeros(objective.size)
    gradient[:size] = J.reshape(-1, size).T @ We.ravel()
    gradient[size:] = -objective.rows.by_socket(We).ravel()
    B, b = knowledge(objective, state)
    information = INFORMATION * curvature(objective, state, weighted) + B.T @ B
    return NormalEquations(information, gradient + B.T @ b, inverse, b, squares, weights)


def curvature(objective: Objective, state: State, weighted: np.ndarray) -> np.ndarray:
    """Return sum_i [J_i, -I]^T V_i [J_i, -I], shape (n, n), for weights V_i, shape (N, 3, 3)."""
    size, S = objective.dense, objective.rows.socket_count
    J = state.linear.by_unknowns
    WJ = weighted @ J
    by_socket = objective.rows.by_socket
    total = np.zeros((objective.size,) * 2)
    total[:size, :size] = J.reshape(-1, size).T @ WJ.reshape(-1, size)
    across = -by_socket(WJ).reshape(3 * S, size)
    total[size:, :size], total[:size, size:] = across, across.T
    for k, own in enumerate(by_socket(weighted)):
        centre = slice(size + 3 * k, size + 3 * k + 3)
        total[centre, centre] = own
    return total


def leverage(objective: Objective, state: State, covariance: np.ndarray) -> np.ndarray:
    """Return how uncertain each error is because the unknowns are: [J_i, -I] Sigma [J_i, -I]^T.

    Args:
        objective: The objective.
        state: Where J is taken.
        covariance: Sigma, of all unknowns, shape (n, n).

    Returns:
        Shape (N, 3, 3) [m^2].
    """
    size, S = objective.dense, objective.rows.socket_count
    J, seated = state.linear.by_unknowns, objective.rows.seated
    sockets = objective.rows.sockets[seated]
    across = covariance[size:, :size].reshape(S, 3, size)
    blocks = [covariance[size + 3 * k :, size + 3 * k :][:3, :3] for k in range(S)]
    own = np.reshape(blocks, (S, 3, 3))
    spread = (J @ covariance[:size, :size]) @ J.transpose(0, 2, 1)
    cross = J[seated] @ across.transpose(0, 2, 1)[sockets]
    spread[seated] = spread[seated] - cross - cross.transpose(0, 2, 1) + own[sockets]
    return spread


def predicted_errors(objective: Objective, state: State, change: np.ndarray) -> np.ndarray:
    """Return the errors after a change of all unknowns, to first order, shape (N, 3) [m]."""
    size, rows = objective.dense, objective.rows
    errors = state.linear.errors + state.linear.by_unknowns @ change[:size]
    errors[rows.seated] -= change[size:].reshape(-1, 3)[rows.sockets[rows.seated]]
    return errors
