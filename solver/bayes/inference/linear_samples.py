"""All samples around a state, linear in every unknown, for the fit of joint error curves."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import SampleRows
from ..model.effects import KNOTS, curve_values, splines
from .curve_prior import GivenCurves
from .objective import linearise
from .state import State


@dataclass(frozen=True)
class LinearSamples:
    """N samples of robots with m joints at most, and d unknowns y beside the curves, see (A7)."""

    columns: np.ndarray
    """[G_i, a_i], shape (N, 3, d + 1) [m]; with given curves, of these but e."""
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
    given: GivenCurves | None
    """Knowledge of one robot's curves by a prior."""
    shift: np.ndarray
    """[R, c without e], shape (robots m KNOTS, d + 1) [rad]; zero where nothing is given."""

    def of(self, rows: np.ndarray) -> "LinearSamples":
        """Return some of the samples."""
        own = ("columns", "readings", "slopes", "arms", "sources")
        return replace(self, **{name: getattr(self, name)[rows] for name in own})

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of all curves' coefficients: robots, m, KNOTS."""
        return self.count, self.readings.shape[1], KNOTS

    @cached_property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """The four coefficients of each sample and joint among all, and their weights."""
        index, weights = splines(self.readings)
        m = self.readings.shape[1]
        first: np.ndarray = (self.arms[:, None] * m + np.arange(m, dtype=np.int64)) * KNOTS
        return index + first[..., None], weights

    @cached_property
    def basis(self) -> np.ndarray:
        """F, derivatives of the errors by all coefficients, shape (3 N, robots m KNOTS)."""
        (places, weights), n = self.places, len(self.readings)
        basis = np.zeros((n, 3, self.count * self.readings.shape[1] * KNOTS))
        for k in range(3):
            basis[np.arange(n)[:, None, None], k, places] = self.slopes[:, k, :, None] * weights
        return basis.reshape(3 * n, -1)

    @cached_property
    def given_covariance(self) -> np.ndarray:
        """Covariance of the given curves' part of the errors, shape (3 N, 3 N) [m^2]."""
        assert self.given is not None
        return self.basis @ self.given.covariance @ self.basis.T

    @cached_property
    def distances(self) -> np.ndarray:
        """Of all pairs of samples, 2 sin(d / 2) of each joint, shape (N, m, N)."""
        s, c = np.sin(self.readings / 2), np.cos(self.readings / 2)
        return 2 * (s[..., None] * c.T - c[..., None] * s.T)


def samples_around(
    state: State, readings: SampleRows, curves: np.ndarray | None, given: GivenCurves | None = None
) -> tuple[State, LinearSamples]:
    """Return a state at the joint positions that curves, (robots, m, KNOTS), make of readings."""
    scene = readings.scene
    widest = max(arm.positions.shape[1] for arm in scene.arms)
    curves = np.zeros((len(scene.arms), widest, KNOTS)) if curves is None else curves
    positions = np.concatenate([_padded(arm.positions, widest) for arm in scene.arms])
    shifts = [
        curve_values(arm.positions, own[: arm.positions.shape[1]].T.ravel())
        for arm, own in zip(scene.arms, curves, strict=True)
    ]
    true = zip(scene.arms, shifts, strict=True)
    arms = tuple(replace(arm, positions=arm.positions + shift) for arm, shift in true)
    rows = SampleRows(replace(scene, arms=arms))
    objective = replace(state.objective, rows=rows)
    linear = linearise(objective, state.x, state.frames)
    state = replace(state, objective=objective, linear=linear)
    n, d = len(positions), objective.size
    robots = np.zeros(n, dtype=np.int64)
    slopes = linear.by_joints.copy()
    for i, (own, model) in enumerate(zip(rows.own, objective.models, strict=True)):
        robots[own] = i
        prismatic = [k for k, j in enumerate(model.robot.actuated) if j.type == "prismatic"]
        slopes[own][:, :, prismatic] = 0.0
    columns, seated = np.zeros((n, 3, d + 1)), np.arange(n)[rows.seated]
    columns[:, :, : objective.dense] = linear.by_unknowns
    centres = objective.dense + 3 * rows.sockets[:, None] + np.arange(3)
    columns[seated[:, None], np.arange(3), centres] = -1.0
    bent = np.concatenate([_padded(shift, widest) for shift in shifts])
    columns[:, :, d] = state.errors - np.einsum("nij,nj->ni", slopes, bent)
    shift = np.zeros((curves.size, d + 1)) if given is None else given.shift(state.x, d)
    samples = LinearSamples(
        columns, positions, slopes, robots, rows.source_of, len(arms), given, shift
    )
    if given is not None:
        columns += (samples.basis @ shift).reshape(columns.shape)
    return state, samples


def _padded(rows: np.ndarray, width: int) -> np.ndarray:
    return np.pad(rows, ((0, 0), (0, width - rows.shape[1])))


def rest_of(
    state: State, share: float = 1.0, *, widened: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return precision and slope of y by priors, known distances, and a share of the volume."""
    d, prior = state.objective.dense, state.prior_precision(widened=widened)
    B, b = state.constraints
    precision = B.T @ B
    precision[:d, :d] += prior
    return precision, state.prior_gradient(prior) + share * state.linear.by_volume + B.T @ b


def posterior_beside(
    state: State, rest: tuple[np.ndarray, np.ndarray], information: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return y and its covariance Sigma, zero for what is held, by [G, a]^T M^-1 [G, a]."""
    (precision, gradient), d, free = rest, len(state.free), np.ix_(state.free, state.free)
    H = (information[:d, :d] + precision)[free]
    unit = 1 / np.sqrt(np.diag(H))
    change, covariance = np.zeros(d), np.zeros((d, d))
    covariance[free] = np.linalg.inv(H * unit[:, None] * unit) * unit[:, None] * unit
    slope = information[:d, d] + gradient
    change[state.free] = -covariance[free] @ slope[state.free]
    return change, covariance
