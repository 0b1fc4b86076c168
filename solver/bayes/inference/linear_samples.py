"""All samples around a state, linear in every unknown, for the fit of joint error curves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import Movement, Noise, SampleRows, sample_degrees, sample_scales
from ..model.effects import KNOTS, curve_values, splines
from .curve_prior import GivenCurves
from .normal_equations import normal_equations
from .objective import linearise
from .posterior import JointPosterior
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

    def weights(self, noises: Sequence[Noise], y: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Return the robust weights by the errors at [y, 1] and coefficients e, shape (N,)."""
        (index, basis), nu = self.places, sample_degrees(noises, self.sources)
        shifts: np.ndarray = np.sum(e[index] * basis, axis=2)
        errors = (self.columns @ y + (self.slopes @ shifts[..., None])[..., 0])[..., None]
        solved = np.linalg.solve(sample_scales(noises, self.sources, self.slopes), errors)
        return (nu + 3) / (nu + np.sum(errors * solved, axis=(1, 2)))

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
    """Return a state at the joint positions that curves make of the readings, and the samples.

    Args:
        state: Where all is made linear again.
        readings: The samples as the encoders read them.
        curves: Coefficients, shape (robots, m, KNOTS) [rad]; None for none.
        given: What is known of the curves.
    """
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


@dataclass(frozen=True)
class Rest:
    """Knowledge of the d unknowns beside the curves besides the samples: a quadratic in y."""

    precision: np.ndarray
    """Shape (d, d); zero for what is held."""
    gradient: np.ndarray
    """Its slope at the state, shape (d,)."""
    free: np.ndarray
    """True for what may change, shape (d,)."""

    def posterior(self, information: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return y and its covariance Sigma, zero for what is held, shapes (d,) and (d, d).

        ``information`` is [G, a]^T M^-1 [G, a], shape (d + 1, d + 1).
        """
        d, free = len(self.free), np.ix_(self.free, self.free)
        H = (information[:d, :d] + self.precision)[free]
        unit = 1 / np.sqrt(np.diag(H))
        change, covariance = np.zeros(d), np.zeros((d, d))
        covariance[free] = np.linalg.inv(H * unit[:, None] * unit) * unit[:, None] * unit
        slope = information[:d, d] + self.gradient
        change[self.free] = -covariance[free] @ slope[self.free]
        return change, covariance


def rest_of(state: State, share: float = 1.0, *, widened: bool = False) -> Rest:
    """Return what priors, known distances and the volume say of the unknowns beside the curves."""
    d, prior, (B, b) = (
        state.objective.dense,
        state.prior_precision(widened=widened),
        state.constraints,
    )
    precision = B.T @ B
    precision[:d, :d] += prior
    gradient = state.prior_gradient(prior) + share * state.linear.by_volume + B.T @ b
    return Rest(precision, gradient, state.free)


def movement_gain(found: JointPosterior, movement: Movement) -> float:
    """Return the rise of the logarithm of the evidence by a further movement, to first order.

    With g the slope of L by its unknowns u, P their prior's precision and S their covariance beside
    all other unknowns, it is (g^T S g + log |S| + log |P|) / 2.
    """
    movements, before = (*found.objective.movements, movement), found.state
    objective, prior = replace(found.objective, movements=movements), movement.prior(len(before.x))
    x, at_zero = (np.pad(part, (0, movement.size)) for part in (before.x, before.at_zero))
    linear = linearise(objective, x, before.frames)
    groups = (*before.groups, prior)
    state = replace(before, objective=objective, x=x, at_zero=at_zero, groups=groups, linear=linear)
    information, gradient = normal_equations(state)
    hessian = information.plus(state.prior_precision())
    covariance = hessian.inverse(state.free[: objective.dense]).dense
    own = slice(len(before.x), len(x))
    S, g = covariance[own, own], gradient[own]
    logs = np.linalg.slogdet(S)[1] + np.linalg.slogdet(prior.precision(prior.width))[1]
    return 0.5 * float(g @ S @ g + logs)
