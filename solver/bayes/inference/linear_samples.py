"""All samples around a state, linear in every unknown, for the fit of joint error curves."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import SampleRows, block_matrix, scaled_inverse, submatrix
from ..model.effects import KNOTS, curve_values, splines
from .objective import linearise
from .state import State


@dataclass(frozen=True)
class LinearSamples:
    """N samples of robots with m joints at most, and d unknowns y beside the curves, see (A7)."""

    columns: np.ndarray
    """[G_i, a_i], shape (N, 3, d + 1) [m]."""
    readings: np.ndarray
    """q_ij, shape (N, m) [rad]."""
    slopes: np.ndarray
    """S_ij, shape (N, 3, m) [m/rad]; 0 for joints that have no curve."""
    arms: np.ndarray
    """Index of each sample's robot, shape (N,)."""
    sources: np.ndarray
    """Index of each sample's noise, shape (N,)."""
    count: int
    """Number of robots."""

    def of(self, rows: np.ndarray) -> "LinearSamples":
        """Return some of the samples."""
        arrays = ("columns", "readings", "slopes", "arms", "sources")
        return replace(self, **{name: getattr(self, name)[rows] for name in arrays})

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of all curves' coefficients: (KNOTS, robots, m)."""
        return KNOTS, self.count, self.readings.shape[1]

    @cached_property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """The four coefficients of each sample and joint among all, and their weights."""
        index, weights = splines(self.readings)
        _, robots, m = self.shape
        first: np.ndarray = self.arms[:, None] * m + np.arange(m, dtype=np.int64)
        return index * (robots * m) + first[..., None], weights

    @cached_property
    def basis(self) -> np.ndarray:
        """F, derivatives of the errors by all coefficients, shape (3 N, KNOTS robots m)."""
        (places, weights), n = self.places, len(self.readings)
        basis = np.zeros((n, 3, np.prod(self.shape)))
        for k in range(3):
            basis[np.arange(n)[:, None, None], k, places] = self.slopes[:, k, :, None] * weights
        return basis.reshape(3 * n, -1)

    @cached_property
    def distances(self) -> np.ndarray:
        """Of all pairs of samples, 2 sin(d / 2) of each joint, shape (N, m, N)."""
        s, c = np.sin(self.readings / 2), np.cos(self.readings / 2)
        return 2 * (s[..., None] * c.T - c[..., None] * s.T)


def samples_around(
    state: State, readings: SampleRows, curves: np.ndarray | None = None
) -> tuple[State, LinearSamples]:
    """Return a state at the joint positions that curves, (KNOTS, robots, m), make of readings."""
    arms, objective = readings.scene.arms, state.objective
    n, d, m = len(readings.source_of), objective.size, state.linear.by_joints.shape[2]
    positions, shifts, turning = np.zeros((n, m)), np.zeros((n, m)), np.zeros((n, m))
    robots = np.zeros(n, dtype=np.int64)
    for i, (rows_of_arm, arm, model) in enumerate(
        zip(readings.own, arms, objective.models, strict=True)
    ):
        width = arm.positions.shape[1]
        positions[rows_of_arm, :width], robots[rows_of_arm] = arm.positions, i
        turning[rows_of_arm, :width] = [joint.type != "prismatic" for joint in model.robot.actuated]
        if curves is not None:
            shifts[rows_of_arm, :width] = curve_values(arm.positions, curves[:, i, :width].ravel())
    true = tuple(
        replace(arm, positions=arm.positions + shifts[rows_of_arm, : arm.positions.shape[1]])
        for rows_of_arm, arm in zip(readings.own, arms, strict=True)
    )
    rows = SampleRows(replace(readings.scene, arms=true))
    objective = replace(objective, rows=rows)
    linear = linearise(objective, state.x, state.frames)
    state = replace(state, objective=objective, linear=linear)
    slopes = linear.by_joints * turning[:, None]
    columns, in_socket = np.zeros((n, 3, d + 1)), np.arange(n)[rows.seated]
    columns[:, :, : objective.dense] = linear.by_unknowns
    centres = objective.dense + 3 * rows.sockets[:, None] + np.arange(3)
    columns[in_socket[:, None], np.arange(3), centres] = -1.0
    columns[:, :, d] = state.errors - np.einsum("nij,nj->ni", slopes, shifts)
    return state, LinearSamples(columns, positions, slopes, robots, rows.source_of, len(arms))


def priors_of_rest(
    state: State, share: float = 1.0, *, widened: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return precision and slope of y by priors, known distances, and a share of the volume."""
    d, prior = state.objective.dense, state.prior_precision(widened=widened)
    B, b = state.constraints
    precision = B.T @ B
    precision[:d, :d] += prior
    return precision, state.prior_gradient(prior) + share * state.linear.by_volume + B.T @ b


def posterior_of_rest(
    state: State, equations: tuple[np.ndarray, np.ndarray], information: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return y and its covariance Sigma, zero for what is held, by [G, a]^T M^-1 [G, a]."""
    (precision, gradient), d, free = equations, len(state.free), state.free
    covariance = scaled_inverse(submatrix(information[:d, :d] + precision, free))
    slope = information[:d, d] + gradient
    change = np.zeros(d)
    change[free] = -covariance @ slope[free]
    return change, block_matrix(d, [(free, covariance)])
