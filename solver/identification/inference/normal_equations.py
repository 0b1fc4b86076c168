"""Curvature and slope of the objective (A3), and the step to its least value within bounds."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .arrow import Arrow, Form
from .state import State

REFINEMENTS = 3
"""Corrections of the step for rounding errors of the inverse. They are large where the
data show nearly nothing of one unknown, and the others very well."""


class Solution(NamedTuple):
    """The unknowns by some normal equations, as a Gaussian."""

    change: np.ndarray
    """Mean d of all unknowns' changes, shape (n,); zero for those that are held."""
    covariance: np.ndarray
    """Sigma, shape (n, n); zero for what is held."""


@dataclass(frozen=True)
class NormalEquations:
    """L to second order, g^T d + d^T H d / 2 for a change d of all unknowns, or a part of it."""

    H: np.ndarray
    """Curvature, shape (n, n)."""
    g: np.ndarray
    """Slope, shape (n,)."""
    form: Form | None = None

    def __add__(self, part: "NormalEquations") -> "NormalEquations":
        """Return their sum with a part that couples no two cells."""
        return replace(self, H=self.H + part.H, g=self.g + part.g)

    def tilted(self, slope: np.ndarray) -> "NormalEquations":
        """Return them with a further slope, shape (n,)."""
        return replace(self, g=self.g + slope)

    def arrow(self, free: np.ndarray) -> Arrow:
        """Return the curvature of what is free, with its cells eliminated."""
        return Arrow(self.H, free, self.form)

    def solution(self, free: np.ndarray) -> Solution:
        """Return the least value, d = -H^-1 g, and the covariance H^-1 of what is free."""
        covariance = self.arrow(free).inverse
        return Solution(-covariance @ self.g, covariance)


def data_equations(state: State) -> NormalEquations:
    """Return the samples' and the measured distances' part (A3).

    H = sum_i k w_i J_i^T C_i^-1 J_i + B^T B
    g = sum_i w_i J_i^T C_i^-1 e_i + B^T b
    """
    A, dense = state.linear.by_unknowns, state.objective.dense
    e = state.errors[:, :, None]
    w = state.weights[:, None, None]
    columns = w * state.inverse_scales @ e
    pulls = columns[:, :, 0]
    B, b = state.constraints
    slope = B.T @ b
    slope[:dense] += np.tensordot(pulls, A, 2)
    slope[dense:] -= state.objective.data.by_socket(pulls).ravel()
    by_turning = _slope_by_turning(state, pulls)
    k_w = state.information[:, None, None]
    H = curvature(state, k_w * state.inverse_scales)
    return NormalEquations(H, slope - by_turning, state.form)


def prior_equations(state: State, *, widened: bool = False) -> NormalEquations:
    """Return the priors' part: H = P and g = P (x - mu)."""
    P = state.prior_precision(widened=widened)
    return NormalEquations(P, P @ state.offset)


def _slope_by_turning(state: State, pulls: np.ndarray) -> np.ndarray:
    """Return the slope that errors would have if the noise did not turn along with the robot.

    ``pulls`` are w_i C_i^-1 e_i, shape (N, 3).
    """
    model = state.objective.model
    torques = np.cross(state.errors, pulls)
    torque = torques.sum(axis=0)
    parameters = model.values(state.x)
    turns = model.ball.turns(parameters)
    slope = np.zeros(state.objective.size)
    slope[: model.geometry] = torque @ turns
    return slope


def curvature(state: State, weights: np.ndarray) -> np.ndarray:
    """Return sum_i J_i^T V_i J_i + B^T B for weights V of samples, shape (N, 3, 3).

    J_i = [A_i, -I] by the other unknowns and the centre of the sample's own socket, and zero by the
    other centres: so A_i^T V_i A_i, -V_i A_i and V_i are summed.
    """
    objective, A = state.objective, state.linear.by_unknowns
    VA = weights @ A
    B = state.constraints.jacobian
    H = B.T @ B
    axes = 0, 1  # of samples, and of space
    others = slice(objective.dense)
    H[others, others] += np.tensordot(A, VA, (axes, axes))
    for k, in_socket in enumerate(objective.data.in_sockets):
        centre = objective.of_socket(k)
        across = VA[in_socket].sum(axis=0)
        H[centre, others] -= across
        H[others, centre] -= across.T
        H[centre, centre] += weights[in_socket].sum(axis=0)
    return H


def leverage(state: State, covariance: np.ndarray) -> np.ndarray:
    """Return how uncertain each error is because the unknowns are: J_i Sigma J_i^T.

    With J_i as in :func:`curvature`, it is A_i S A_i^T - A_i S_c - (A_i S_c)^T + S_cc for the
    covariance S of the other unknowns, S_c theirs with the centre, and S_cc that of the centre.
    """
    objective, A = state.objective, state.linear.by_unknowns
    others = slice(objective.dense)
    A_T = A.transpose(0, 2, 1)
    L = (A @ covariance[others, others]) @ A_T
    for k, in_socket in enumerate(objective.data.in_sockets):
        centre = objective.of_socket(k)
        across = A[in_socket] @ covariance[others, centre]
        L[in_socket] += covariance[centre, centre] - across
        L[in_socket] -= across.transpose(0, 2, 1)
    return L


@dataclass(frozen=True)
class BoundedProblem:
    """The search for the least value of L to second order, with some unknowns never below zero."""

    equations: NormalEquations
    x: np.ndarray
    """The unknowns before the change, shape (n,)."""
    free: np.ndarray
    """True for those that are not held, shape (n,)."""
    bounded: np.ndarray
    """True for those that cannot be below zero, shape (n,)."""

    def solution(self, covariance: np.ndarray | None = None) -> Solution:
        """Return the change to the minimum within the bounds, by the method of active sets.

        The inverse of all that is free may be known from before.
        """
        H = self.equations.H
        g = self.equations.g
        x, bounded = self.x, self.bounded
        at_bound = bounded & (x == 0) & (g > 0)
        if covariance is None or at_bound.any():
            covariance = self._covariance(at_bound)
        change = self._step(at_bound, covariance)
        for _ in range(3 * int(bounded.sum())):
            below = bounded & ~at_bound & (x + change < 0)
            slope = np.where(at_bound, g + H @ change, 0.0)
            if below.any():
                at_bound |= below
            elif (slope < 0).any():
                at_bound[np.argmin(slope)] = False
            else:
                break
            covariance = self._covariance(at_bound)
            change = self._step(at_bound, covariance)
        return Solution(change, covariance)

    def _covariance(self, at_bound: np.ndarray) -> np.ndarray:
        """Return the inverse of the curvature of what is neither held nor at its bound."""
        free = self.free & ~at_bound
        return self.equations.arrow(free).inverse

    def _step(self, at_bound: np.ndarray, covariance: np.ndarray) -> np.ndarray:
        """Return the change to the minimum, with unknowns at their bounds held there."""
        equations = self.equations
        change = np.where(at_bound, -self.x, 0.0)
        for _ in range(REFINEMENTS):
            slope = equations.g + equations.H @ change
            change -= covariance @ slope
        return change
