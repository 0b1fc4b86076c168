"""All samples around a state, linear in every unknown, for the fit of joint error curves."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..model import Movement, Noise, SampleRows
from ..model.effects import KNOTS, curve_values, splines
from .normal_equations import normal_equations
from .objective import (
    Objective,
    State,
    build_objective,
    constraint_residuals,
    free_unknowns,
    linearise,
    prior_gradient,
    prior_precision,
)
from .posterior import JointPosterior


@dataclass(frozen=True)
class LinearSamples:
    """N samples of robots with m joints at most, and d unknowns beside the curves."""

    errors: np.ndarray
    """a_i, shape (N, 3) [m]."""
    by_rest: np.ndarray
    """G_i, shape (N, 3, d)."""
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
    given: np.ndarray | None = None
    """Covariance of the coefficients of one robot's curves, shape (m KNOTS, m KNOTS) [rad^2], by a
    prior that tells of them; None for a Gaussian process of all curves alike."""

    def of(self, rows: np.ndarray) -> "LinearSamples":
        """Return some of the samples."""
        own = ("errors", "by_rest", "readings", "slopes", "arms", "sources")
        return replace(self, **{name: getattr(self, name)[rows] for name in own})

    def scales(self, noises: Sequence[Noise]) -> np.ndarray:
        """Return C_i of each sample by its noise, shape (N, 3, 3) [m^2]."""
        scales = np.empty((len(self.errors), 3, 3))
        for k, noise in enumerate(noises):
            rows = self.sources == k
            scales[rows] = noise.scales(self.slopes[rows])
        return scales

    def degrees(self, noises: Sequence[Noise]) -> np.ndarray:
        """Return nu of each sample, shape (N,)."""
        return np.array([noise.nu for noise in noises])[self.sources]

    @cached_property
    def basis(self) -> np.ndarray:
        """Derivatives of one robot's errors by its curves, shape (N, 3, m KNOTS)."""
        index, weights = splines(self.readings)
        n, m = self.readings.shape
        flat = np.zeros((n, m, KNOTS))
        flat[np.arange(n)[:, None, None], np.arange(m)[:, None], index] = weights
        return (self.slopes[..., None] * flat[:, None]).reshape(n, 3, -1)

    @cached_property
    def given_covariance(self) -> np.ndarray:
        """Covariance of the curves' part of the errors by that prior, shape (3 N, 3 N) [m^2]."""
        flat = self.basis.reshape(-1, self.basis.shape[2])
        return flat @ self.given @ flat.T

    @cached_property
    def distances(self) -> np.ndarray:
        """Of all pairs of samples, 2 sin(d / 2) of each joint, shape (N, m, N)."""
        s, c = np.sin(self.readings / 2), np.cos(self.readings / 2)
        return 2 * (s[..., None] * c.T - c[..., None] * s.T)


def linear_samples(objective: Objective, state: State, curves: np.ndarray) -> LinearSamples:
    """Return the samples around a state of the unknowns beside the curves."""
    rows, linear = objective.rows, state.linear
    arms, sources = np.zeros((2, len(curves)), dtype=np.int64)
    slopes = linear.by_joints.copy()
    for i, (own, model) in enumerate(zip(rows.own, objective.model.models, strict=True)):
        arms[own] = i
        prismatic = [k for k, j in enumerate(model.robot.actuated) if j.type == "prismatic"]
        slopes[own][:, :, prismatic] = 0.0
    for k, source in enumerate(rows.sources):
        sources[source] = k
    centres = np.zeros((len(curves), 3, 3 * rows.socket_count))
    for i in np.flatnonzero(rows.sockets >= 0).tolist():
        begin = 3 * int(rows.sockets[i])
        centres[i, :, begin : begin + 3] = -np.eye(3)
    return LinearSamples(
        linear.errors - np.einsum("nij,nj->ni", slopes, curves),
        np.concatenate([linear.by_unknowns, centres], axis=2),
        np.concatenate(
            [
                np.pad(arm.positions, ((0, 0), (0, slopes.shape[2] - arm.positions.shape[1])))
                for arm in rows.scene.arms
            ]
        )
        - curves,
        slopes,
        arms,
        sources,
        len(rows.own),
    )


@dataclass(frozen=True)
class Rest:
    """What is known of the d unknowns beside the curves besides the samples: a quadratic in y."""

    precision: np.ndarray
    """Shape (d, d); zero for what is held."""
    gradient: np.ndarray
    """Its slope at the state, shape (d,)."""
    free: np.ndarray
    """Which may change, shape (d,)."""


def rest_of(
    objective: Objective, state: State, share: float = 1.0, *, widened: bool = False
) -> Rest:
    """Return what priors, known distances and the volume say of the unknowns beside the curves."""
    d = objective.dense
    prior = prior_precision(objective, state, widened=widened)
    B, b = constraint_residuals(objective, state)
    precision = B.T @ B
    precision[:d, :d] += prior
    gradient = prior_gradient(objective, state, prior) + share * state.linear.by_volume + B.T @ b
    return Rest(precision, gradient, free_unknowns(objective, state))


def resumed(found: JointPosterior, objective: Objective) -> State:
    """Return the state of the iteration that a result stands for."""
    rows, size = objective.rows, objective.model.size
    groups = [
        replace(g, members=g.members + own.start)
        for own, arm in zip(objective.model.own, found.arms, strict=True)
        for g in arm.groups
    ]
    x = np.concatenate([*(arm.x for arm in found.arms), *(u for _, u, _ in found.movements)])
    begin = objective.model.own[-1].stop
    for one, _, prior in found.movements:
        groups.append(replace(prior, members=prior.members + begin))
        begin += one.size
    at_zero = np.zeros(size, dtype=bool)
    for group in groups:
        none = ~(np.abs(x[group.members]) > 0) if group.non_negative else group.width == 0
        at_zero[group.members] = none
    frames, centres = tuple(found.frames.values()), found.arms[0].centres
    linear = linearise(objective, x, centres, frames)
    return State(x, centres, frames, tuple(groups), found.noises_of(rows), at_zero, linear)


def with_curves(objective: Objective, coefficients: np.ndarray) -> tuple[Objective, np.ndarray]:
    """Return the objective of samples at the joint positions that curves make of the readings."""
    scene = objective.rows.scene
    parts = [
        curve_values(arm.positions, own[: arm.positions.shape[1]].T.ravel())
        for arm, own in zip(scene.arms, coefficients, strict=True)
    ]
    arms = tuple(
        replace(arm, positions=arm.positions + part)
        for arm, part in zip(scene.arms, parts, strict=True)
    )
    widest = max(part.shape[1] for part in parts)
    shifts = [np.pad(part, ((0, 0), (0, widest - part.shape[1]))) for part in parts]
    moved = replace(objective, rows=SampleRows(replace(scene, arms=arms)))
    return moved, np.concatenate(shifts)


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
