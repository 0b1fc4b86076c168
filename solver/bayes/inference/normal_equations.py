"""Curvature and slope of the data's part of the objective, and a Gauss-Newton step."""

import numpy as np

from ..model import block_matrix, scaled_inverse, submatrix
from .state import State

REFINEMENTS = 3
"""Corrections of the step for rounding errors of the inverse. They are large where the
data show nearly nothing of one unknown, and the others very well."""


def inverse_of_free(H: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Return the inverse of the rows and columns that are free, zero for what is held."""
    return block_matrix(len(H), [(free, scaled_inverse(submatrix(H, free)))])


def active_set_step(
    H: np.ndarray,
    gradient: np.ndarray,
    x: np.ndarray,
    free: np.ndarray,
    bounded: np.ndarray,
    inverse: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the step to the minimum of a quadratic function within the bounds, and H^-1 there.

    The inverse of all that is free may be known from before.
    """
    at_bound = bounded & (x == 0) & (gradient > 0)
    change, covariance = np.zeros(len(x)), inverse
    if covariance is None or at_bound.any():
        covariance = inverse_of_free(H, free & ~at_bound)
    for _ in range(3 * int(bounded.sum()) + 1):
        change = np.where(at_bound, -x, 0.0)
        for _ in range(REFINEMENTS):
            change -= covariance @ (gradient + H @ change)
        below = bounded & ~at_bound & (x + change < 0)
        slope = np.where(at_bound, gradient + H @ change, 0.0)
        if not below.any() and not (slope < 0).any():
            break
        if below.any():
            at_bound |= below
        else:
            at_bound[np.argmin(slope)] = False
        covariance = inverse_of_free(H, free & ~at_bound)
    return change, covariance


def normal_equations(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return curvature and slope of the samples' and the measured distances' part of L (A3)."""
    inverse, errors = state.inverse_scales, state.errors[:, :, None]
    weighed = (state.weights[:, None, None] * inverse @ errors)[:, :, 0]
    B, b = state.constraints
    slope = np.tensordot(weighed, state.linear.by_unknowns, 2) + B.T @ b
    slope -= _by_turning(state, weighed)
    return curvature(state, state.information[:, None, None] * inverse), slope


def _by_turning(state: State, weighed: np.ndarray) -> np.ndarray:
    """Return the slope that errors would have if the noise did not turn along with the robot."""
    model, slope = state.objective.model, np.zeros(state.objective.size)
    torque = np.cross(state.errors, weighed).sum(axis=0)
    turns = model.ball.turns(model.values(state.x[: model.size]))
    slope[: model.geometry] = torque @ turns
    return slope


def curvature(state: State, weights: np.ndarray) -> np.ndarray:
    """Return sum_i J_i^T V_i J_i + B^T B for weights V of samples, shape (N, 3, 3)."""
    J, (B, _) = state.linear.by_unknowns, state.constraints
    samples_and_axes = (0, 1)
    return np.tensordot(J, weights @ J, (samples_and_axes, samples_and_axes)) + B.T @ B


def leverage(state: State, covariance: np.ndarray) -> np.ndarray:
    """Return how uncertain each error is because the unknowns are: J_i Sigma J_i^T."""
    J = state.linear.by_unknowns
    return (J @ covariance) @ J.transpose(0, 2, 1)
