"""Joint error curves given everything else, and both together, at given scales."""

from dataclasses import dataclass

import numpy as np

from ...data import MultiRobotObservations, Pose
from ..model import SampleRows
from ..model.effects import CURVE, KNOTS
from .curve_marginal import CurveFit, inverse_root
from .curve_prior import CurvePrior
from .linear_samples import LinearSamples, samples_around
from .objective import Objective, linearise
from .posterior import Posterior
from .state import State

MOST_SAMPLES = 300
"""Of which the evidence is worked out, and with which the curves are fitted without any basis."""
BATCH = 1000
"""Samples whose part of the normal equations is added at once."""


@dataclass(frozen=True)
class GivenRest:
    """Coefficients e of all curves, Gaussian given y: by M, or of many samples by splines."""

    samples: LinearSamples
    information: np.ndarray
    """[G, a]^T M^-1 [G, a], shape (d + 1, d + 1)."""
    root: np.ndarray
    """Rows whose squares are M^-1, or of many samples, the inverse of the curvature of e."""
    along: np.ndarray
    """These times [G, a], or times its part of the slope of e, shape (rows, d + 1)."""
    prior: np.ndarray | None = None
    """Block of the prior covariance; None for many samples."""

    def mean(self, y: np.ndarray) -> np.ndarray:
        """Return the mean of e for [y, 1], shape (robots m KNOTS,), or for columns of such."""
        pulled = self.root.T @ (self.along @ y)
        if self.prior is None:
            return -pulled
        pulled, own = self.samples.basis.T @ pulled, len(self.prior)
        return -(self.prior @ pulled.reshape(len(pulled) // own, own, -1)).reshape(pulled.shape)

    def with_rest(self, known: np.ndarray) -> np.ndarray:
        """Return the covariance of y, then of all curves, by that of y, shape (d, d)."""
        root, d, basis = self.root, len(known), self.samples.basis
        gain = (self.mean(np.eye(d + 1)) + self.samples.shift)[:, :d]
        across, whole = gain @ known, np.empty((d + len(gain),) * 2)
        whole[:d, :d], whole[d:, :d], whole[:d, d:] = known, across, across.T
        if self.prior is None:
            apart = np.matmul(root.T, root, out=whole[d:, d:])
        else:
            own = len(self.prior)
            root = root @ (basis.reshape(-1, own) @ self.prior).reshape(basis.shape)
            apart = np.matmul(root.T, root, out=whole[d:, d:])
            np.negative(apart, out=apart)
            for begin in range(0, len(apart), own):
                apart[begin : begin + own, begin : begin + own] += self.prior
        apart += across @ gain.T
        return whole


def given_rest(fit: CurveFit) -> GivenRest:
    """Return the curves by what a fit's samples tell."""
    samples, columns, prior = fit.samples, fit.samples.columns, fit.prior.inverse
    if len(columns) <= MOST_SAMPLES:
        along = fit.whitened
        return GivenRest(samples, along.T @ along, fit.root[0], along, fit.prior.block)
    flat = columns.reshape(3 * len(columns), -1)
    weighted = fit.weights[:, None, None] * np.linalg.inv(fit.scales)
    curvature, across = _normal_equations(samples, weighted)
    for begin in range(0, len(curvature), len(prior)):
        curvature[begin : begin + len(prior), begin : begin + len(prior)] += prior
    root = inverse_root(curvature)
    along = root @ across
    information = flat.T @ (weighted @ columns).reshape(flat.shape) - along.T @ along
    return GivenRest(samples, information, root, along)


def _normal_equations(
    samples: LinearSamples, weighted: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return F^T W F and F^T W [G, a] of the coefficients of all curves."""
    (places, basis), m = samples.places, samples.readings.shape[1]
    size = samples.count * m * KNOTS
    curvature, across = np.zeros(size * size), np.zeros((size, samples.columns.shape[2]))
    for begin in range(0, len(places), BATCH):
        some = slice(begin, begin + BATCH)
        index = places[some].reshape(-1, 4 * m)
        F = (samples.slopes[some][..., None] * basis[some][:, None]).reshape(-1, 3, 4 * m)
        WF = weighted[some] @ F
        np.add.at(across, index, WF.swapaxes(1, 2) @ samples.columns[some])
        pairs = index[:, :, None] * size + index[:, None]
        curvature += np.bincount(pairs.ravel(), (F.swapaxes(1, 2) @ WF).ravel(), size * size)
    return curvature.reshape(size, size), across


def restored_covariance(
    found: Posterior,
    scene: MultiRobotObservations,
    frames: tuple[Pose, ...],
    scales: tuple[float, float],
) -> np.ndarray:
    """Return the covariance of a robot's unknowns and sockets from that of all but its curves.

    That is the covariance of what is found in a scene, frames between unknowns and sockets. Scales
    are amplitude and length of the curves [rad], zero without any.
    """
    model, size, of_rest = found.model, found.model.scalars, found.covariance
    x, d, curves = found.x[:size], len(of_rest), found.deflection.curves
    kept = np.r_[:size, d - found.centres.size : d]
    if curves is None:
        return of_rest[np.ix_(kept, kept)]
    plain = model.with_effects({*model.extensions} - {CURVE.name})
    objective = Objective((plain,), (), SampleRows(scene))
    noises = tuple(found.noises[kind] for _, kind in objective.rows.source_kinds)
    linear = linearise(objective, x, frames)
    state = State(objective, x, found.centres, frames, (), noises, x != x, linear)
    around = samples_around(state, objective.rows, curves.T[None])
    nu = state.degrees
    told = found.weights * (nu + 3) ** 2 / (nu * (nu + 5))
    whole = given_rest(CurveFit(*around, CurvePrior(*scales), told)).with_rest(of_rest)
    order = d + np.arange(curves.size).reshape(curves.shape[::-1]).T.ravel()
    picked = np.r_[:size, order, kept[size:]]
    return whole[np.ix_(picked, picked)]
