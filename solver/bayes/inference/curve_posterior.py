"""Joint error curves given everything else, and both together, at given scales."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...data import MultiRobotObservations, Pose
from ..model import Noise, sample_degrees, sample_scales
from ..model.effects import CURVE, KNOTS
from .curve_marginal import curve_covariance, inverse_root, marginal_root
from .curve_prior import CurvePrior
from .linear_samples import LinearSamples, samples_around
from .objective import build_objective, linearise
from .posterior import Posterior
from .state import State

MOST_SAMPLES = 300
"""Of which the evidence is worked out, and with which the curves are fitted without any basis."""
BATCH = 1000
"""Samples whose part of the normal equations is added at once."""


@dataclass(frozen=True)
class GivenRest:
    """Coefficients e of all curves, Gaussian given y."""

    information: np.ndarray
    """[G, a]^T M^-1 [G, a], shape (d + 1, d + 1)."""
    root: np.ndarray
    """Rows whose squares are M^-1, or without the basis, the inverse of the curvature of e."""
    along: np.ndarray
    """These times [G, a], or times its part of the slope of e, shape (rows, d + 1)."""
    prior: np.ndarray
    """Block of the prior covariance."""
    basis: np.ndarray | None = None
    """F; None where the curves are by the normal equations of their splines."""

    def mean(self, y: np.ndarray) -> np.ndarray:
        """Return the mean of e for [y, 1], shape (robots m KNOTS,), or for columns of such."""
        pulled = self.root.T @ (self.along @ y)
        if self.basis is None:
            return -pulled
        pulled, own = self.basis.T @ pulled, len(self.prior)
        return -(self.prior @ pulled.reshape(len(pulled) // own, own, -1)).reshape(pulled.shape)

    def with_rest(self, known: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """Return the covariance of y, then of all curves, by that of y, shape (d, d).

        ``shift`` is [R, ...] of given curves, shape (robots m KNOTS, d + 1); zero of a process.
        """
        root, d, own = self.root, len(known), len(self.prior)
        gain = (self.mean(np.eye(d + 1)) + shift)[:, :d]
        across, whole = gain @ known, np.empty((d + len(gain),) * 2)
        whole[:d, :d], whole[d:, :d], whole[:d, d:] = known, across, across.T
        if self.basis is not None:
            root = root @ (self.basis.reshape(-1, own) @ self.prior).reshape(self.basis.shape)
        apart = np.matmul(root.T, root, out=whole[d:, d:])
        if self.basis is not None:
            np.negative(apart, out=apart)
            for begin in range(0, len(apart), own):
                apart[begin : begin + own, begin : begin + own] += self.prior
        apart += across @ gain.T
        return whole


def given_rest(
    samples: LinearSamples, noises: Sequence[Noise], prior: CurvePrior, told: np.ndarray
) -> GivenRest:
    """Return the curves by what samples tell, shape (N,): of few by M, else by their splines."""
    C, columns = sample_scales(noises, samples.sources, samples.slopes), samples.columns
    flat = columns.reshape(3 * len(C), -1)
    if len(C) <= MOST_SAMPLES:
        root = marginal_root(C / told[:, None, None], curve_covariance(samples, prior))[0]
        along = root @ flat
        return GivenRest(along.T @ along, root, along, prior.block, samples.basis)
    weighted = told[:, None, None] * np.linalg.inv(C)
    curvature, across = _normal_equations(samples, weighted)
    for begin in range(0, len(curvature), len(prior.inverse)):
        own = slice(begin, begin + len(prior.inverse))
        curvature[own, own] += prior.inverse
    root = inverse_root(curvature)
    along = root @ across
    information = flat.T @ (weighted @ columns).reshape(flat.shape) - along.T @ along
    return GivenRest(information, root, along, prior.block)


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

    Args:
        found: The result, with the covariance of y: the unknowns but for curves, the frames, the
            sockets.
        scene: What it was fitted to.
        frames: Poses of the instruments' frames.
        scales: Amplitude and length of the curves [rad]; zero without any.
    """
    model, size, of_rest = found.model, found.model.scalars, found.covariance
    x, d, curves = found.x[:size], len(of_rest), found.deflection.curves
    kept = np.r_[:size, d - found.centres.size : d]
    if curves is None:
        return of_rest[np.ix_(kept, kept)]
    objective = build_objective([model.with_effects({*model.extensions} - {CURVE.name})], scene)
    noises = tuple(found.noises[kind] for _, kind in objective.rows.source_kinds)
    linear = linearise(objective, x, frames)
    state = State(objective, x, found.centres, frames, (), noises, x != x, linear)
    _, samples = samples_around(state, objective.rows, curves.T[None])
    nu = sample_degrees(noises, samples.sources)
    told = found.weights * (nu + 3) ** 2 / (nu * (nu + 5))
    part = given_rest(samples, noises, CurvePrior(*scales), told)
    whole = part.with_rest(of_rest, samples.shift)
    order = d + np.arange(curves.size).reshape(curves.shape[::-1]).T.ravel()
    picked = np.r_[:size, order, kept[size:]]
    return whole[np.ix_(picked, picked)]
