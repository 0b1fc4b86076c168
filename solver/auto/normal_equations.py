"""What the data say of the unknowns at a state: weights, curvature, gradient, leverage.

A sample's error e_i = Phi(x, q_i) - m_s(i) depends on x by J_i, shape (3, size), and on the centre
of its own socket alone, by -I. Nothing of the size of samples times sockets is ever built, so time
and memory grow with the number of samples, however many sockets they are in.
"""

from dataclasses import dataclass

import numpy as np

from .noise import INFORMATION, NU
from .objective import Objective, State, distance_rows

__all__ = ["NormalEquations", "leverage", "normal_equations", "predicted_errors", "weigh"]


@dataclass(frozen=True)
class NormalEquations:
    """The quadratic approximation of the data's part of the objective L, in all n unknowns."""

    information: np.ndarray
    """Its curvature, shape (n, n)."""
    gradient: np.ndarray
    """Its slope, shape (n,)."""
    inverse_scales: np.ndarray
    """C_i^-1, shape (N, 3, 3) [1/m^2]."""
    weights: np.ndarray
    """w_i, robust weight of each sample, shape (N,)."""


def weigh(state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return C_i^-1, e_i^T C_i^-1 e_i, and the robust weights w_i.

        w_i = (nu + 3) / (nu + e_i^T C_i^-1 e_i)                                           (2)

    With them, weighted squares have the gradient of Student's distribution.
    """
    inverse = np.linalg.inv(state.noise.scales(state.linear.by_joints))
    e = state.linear.errors
    squares = np.einsum("ni,nij,nj->n", e, inverse, e)
    return inverse, squares, (NU + 3) / (NU + squares)


def normal_equations(objective: Objective, state: State) -> NormalEquations:
    """Return curvature and slope of the samples' and the measured distances' part of L.

    curvature  sum_i k w_i [J_i, -I]^T C_i^-1 [J_i, -I]  +  B^T W^T W B
    slope      sum_i w_i [J_i, -I]^T C_i^-1 e_i          +  B^T W^T W (l - d)

    B is the derivative of the distances, and k is what a sample of Student's distribution tells,
    relative to a Gaussian one.
    """
    inverse, _, weights = weigh(state)
    size, S = objective.model.size, objective.data.socket_count
    J = state.linear.by_unknowns
    weighted = inverse * weights[:, None, None]
    WJ = weighted @ J
    We = np.einsum("nij,nj->ni", weighted, state.linear.errors)
    information, gradient = np.zeros((objective.size,) * 2), np.zeros(objective.size)
    information[:size, :size] = np.tensordot(J, WJ, ((0, 1), (0, 1)))
    gradient[:size] = np.tensordot(J, We, ((0, 1), (0, 1)))
    sockets = objective.data.sockets
    across, own, slope = np.zeros((S, 3, size)), np.zeros((S, 3, 3)), np.zeros((S, 3))
    np.add.at(across, sockets, -WJ)
    np.add.at(own, sockets, weighted)
    np.add.at(slope, sockets, -We)
    information[size:, :size] = across.reshape(3 * S, size)
    information[:size, size:] = information[size:, :size].T
    for k in range(S):
        rows = slice(size + 3 * k, size + 3 * k + 3)
        information[rows, rows] = own[k]
    gradient[size:] = slope.ravel()
    B, b = distance_rows(objective, state)
    information = INFORMATION * information + B.T @ B
    return NormalEquations(information, gradient + B.T @ b, inverse, weights)


def leverage(objective: Objective, state: State, covariance: np.ndarray) -> np.ndarray:
    """Return what the uncertainty of the unknowns does to each error: [J, -I] Sigma [J, -I]^T.

    Args:
        objective: The objective.
        state: Where J is taken.
        covariance: Sigma, of all unknowns, shape (n, n).

    Returns:
        Shape (N, 3, 3) [m^2].
    """
    size, S = objective.model.size, objective.data.socket_count
    J, sockets = state.linear.by_unknowns, objective.data.sockets
    across = covariance[size:, :size].reshape(S, 3, size)
    own = np.array([covariance[size + 3 * k :, size + 3 * k :][:3, :3] for k in range(S)])
    cross = J @ across.transpose(0, 2, 1)[sockets]
    return (
        (J @ covariance[:size, :size]) @ J.transpose(0, 2, 1)
        - cross
        - cross.transpose(0, 2, 1)
        + own[sockets]
    )


def predicted_errors(objective: Objective, state: State, change: np.ndarray) -> np.ndarray:
    """Return the errors after a change of all unknowns, to first order, shape (N, 3) [m]."""
    size = objective.model.size
    centres = change[size:].reshape(-1, 3)
    linear = state.linear
    return linear.errors + linear.by_unknowns @ change[:size] - centres[objective.data.sockets]
