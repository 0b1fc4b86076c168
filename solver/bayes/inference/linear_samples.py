"""All samples around a state, linear in every unknown, for the fit of joint error curves."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...data import Observations
from ..model.effects import KNOTS, curve_values, splines
from .normal_equations import inverse_of_free
from .objective import linearise
from .state import State


@dataclass(frozen=True)
class LinearSamples:
    """N samples of a robot with m joints, and d unknowns y beside the curves, see (A7)."""

    columns: np.ndarray
    """[G_i, a_i], shape (N, 3, d + 1) [m]."""
    readings: np.ndarray
    """q_ij, shape (N, m) [rad]."""
    slopes: np.ndarray
    """S_ij, shape (N, 3, m) [m/rad]; 0 for joints that have no curve."""
    sources: np.ndarray
    """Index of each sample's noise, shape (N,)."""

    def of(self, rows: np.ndarray) -> "LinearSamples":
        """Return some of the samples."""
        arrays = ("columns", "readings", "slopes", "sources")
        return replace(self, **{name: getattr(self, name)[rows] for name in arrays})

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of all curves' coefficients: (KNOTS, m)."""
        return KNOTS, self.readings.shape[1]

    @cached_property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """The four coefficients of each sample and joint among all, and their weights."""
        index, weights = splines(self.readings)
        _, m = self.shape
        return index * m + np.arange(m, dtype=np.int64)[:, None], weights

    @cached_property
    def basis(self) -> np.ndarray:
        """F, derivatives of the errors by all coefficients, shape (3 N, KNOTS m)."""
        places, weights = self.places
        basis = np.zeros((len(places), 3, np.prod(self.shape)))
        rows = np.arange(len(places))[:, None, None]
        for k in range(3):
            basis[rows, k, places] = self.slopes[:, k, :, None] * weights
        return basis.reshape(3 * len(places), -1)

    @cached_property
    def distances(self) -> np.ndarray:
        """Of all pairs of samples, 2 sin(d / 2) of each joint, shape (N, m, N)."""
        s, c = np.sin(self.readings / 2), np.cos(self.readings / 2)
        return 2 * (s[..., None] * c.T - c[..., None] * s.T)


def samples_around(
    state: State, readings: Observations, curves: np.ndarray | None = None
) -> tuple[State, LinearSamples]:
    """Return a state at the joint positions that curves, (KNOTS, m), make of readings."""
    objective, positions = state.objective, readings.positions
    turning = np.array(
        [joint.type != "prismatic" for joint in objective.model.robot.actuated]
    )
    shifts = np.zeros(positions.shape)
    if curves is not None:
        shifts = curve_values(positions, curves.ravel())
    data = replace(readings, positions=positions + shifts)
    objective = replace(objective, data=data)
    linear = linearise(objective, state.x, state.frames)
    state = replace(state, objective=objective, linear=linear)
    slopes = linear.by_joints * turning
    beside_curves = state.errors[:, :, None] - slopes @ shifts[:, :, None]
    columns = np.concatenate([linear.by_unknowns, beside_curves], axis=2)
    return state, LinearSamples(columns, positions, slopes, data.source_of)


def priors_of_rest(
    state: State, share: float = 1.0, *, widened: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return precision and slope of y by priors, known distances, and a share of the volume."""
    prior, (B, b) = state.prior_precision(widened=widened), state.constraints
    return (
        B.T @ B + prior,
        B.T @ b + prior @ state.offset + share * state.linear.by_volume,
    )


def posterior_of_rest(
    state: State, equations: tuple[np.ndarray, np.ndarray], information: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return y and its covariance Sigma, zero for what is held, by [G, a]^T M^-1 [G, a]."""
    precision, gradient = equations
    covariance = inverse_of_free(information[:-1, :-1] + precision, state.free)
    return -covariance @ (information[:-1, -1] + gradient), covariance
