"""All samples around a state, linear in every unknown, for the fit of joint error curves."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..identification.data import Observations, SampleRows
from ..identification.effects import KNOTS, curve_values, splines
from ..identification.inference import NormalEquations, Solution, State, prior_equations


@dataclass(frozen=True)
class LinearSamples(SampleRows):
    """N samples of a robot with m joints, and d unknowns y beside the curves, see (A7)."""

    by_others: np.ndarray
    """G_i but for the sockets' centres, which come last, shape (N, 3, e)."""
    a: np.ndarray
    """a_i, shape (N, 3, 1) [m]."""
    sockets: np.ndarray
    """Index of each sample's socket, shape (N,); -1 for none."""
    slopes: np.ndarray
    """S_ij, shape (N, 3, m) [m/rad]; 0 for joints that have no curve."""
    sources: np.ndarray
    """Index of each sample's noise, shape (N,)."""
    socket_count: int

    @cached_property
    def columns(self) -> np.ndarray:
        """[G_i, a_i], shape (N, 3, d + 1) [m]."""
        by_centres = np.zeros((len(self.a), self.socket_count, 3, 3))
        seated = np.flatnonzero(self.sockets >= 0)
        by_centres[seated, self.sockets[seated]] = -np.eye(3)
        flat = by_centres.transpose(0, 2, 1, 3).reshape(len(self.a), 3, -1)
        return np.concatenate([self.by_others, flat, self.a], axis=2)

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of all curves' coefficients: (KNOTS, m)."""
        return KNOTS, self.q.shape[1]

    @cached_property
    def coefficients(self) -> tuple[np.ndarray, np.ndarray]:
        """Indices of each sample's and joint's four coefficients, and their weights, (N, m, 4)."""
        knots, weights = splines(self.q)
        _, m = self.shape
        joints = np.arange(m, dtype=np.int64)[:, None]
        return knots * m + joints, weights

    @cached_property
    def basis(self) -> np.ndarray:
        """F, derivatives of the errors by all coefficients, shape (3 N, KNOTS m)."""
        coefficients, weights = self.coefficients
        N = len(coefficients)
        basis = np.zeros((N, 3, np.prod(self.shape)))
        rows = np.arange(N)[:, None, None]
        for axis in range(3):
            S = self.slopes[:, axis, :, None]
            basis[rows, axis, coefficients] = S * weights
        return basis.reshape(3 * N, -1)

    @cached_property
    def distances(self) -> np.ndarray:
        """Of all pairs of samples, 2 sin(d / 2) of each joint, shape (N, m, N)."""
        halves = self.q / 2
        s, c = np.sin(halves), np.cos(halves)
        sines = s[..., None] * c.T - c[..., None] * s.T
        return 2 * sines


def samples_around(
    state: State,
    readings: Observations,
    curves: np.ndarray | None = None,
) -> tuple[State, LinearSamples]:
    """Return a state at the joint positions that curves, (KNOTS, m), make of readings."""
    q = readings.q
    shifts = np.zeros(q.shape)
    if curves is not None:
        shifts = curve_values(q, curves.ravel())
    data = replace(readings, q=q + shifts)
    objective = replace(state.objective, data=data)
    state = replace(state, objective=objective).linearised()
    joints = objective.model.robot.actuated
    revolute = np.array([joint.type != "prismatic" for joint in joints])
    slopes = state.linear.by_joints * revolute
    by_curves = slopes @ shifts[:, :, None]
    a = state.errors[:, :, None] - by_curves
    samples = LinearSamples(
        q=q,
        by_others=state.linear.by_unknowns,
        a=a,
        sockets=data.sockets,
        slopes=slopes,
        sources=data.source_of,
        socket_count=data.socket_count,
    )
    return state, samples


def equations_of_rest(
    state: State,
    share: float = 1.0,
    *,
    widened: bool = False,
) -> NormalEquations:
    """Return those of y by priors, known distances, and a share of the volume."""
    B, b = state.constraints
    distances = NormalEquations(B.T @ B, B.T @ b)
    equations = distances + prior_equations(state, widened=widened)
    return equations.tilted(share * state.linear.volume.slope)


def solution_of_rest(
    state: State,
    equations: NormalEquations,
    information: np.ndarray,
) -> Solution:
    """Return y and its covariance Sigma by [G, a]^T M^-1 [G, a] and other equations."""
    H, g = information[:-1, :-1], information[:-1, -1]
    of_samples = NormalEquations(H, g)
    return (of_samples + equations).solution(state.free)
