"""Joint error curves given everything else, and both together, at given scales."""

from dataclasses import dataclass

import numpy as np

from ...data import MultiRobotObservations, Pose
from ..model import SampleRows
from ..model.effects import CURVE
from .curve_marginal import CurveFit, inverse_root
from .curve_prior import CurvePrior, add_blocks
from .linear_samples import samples_around
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

    fit: CurveFit
    information: np.ndarray
    """[G, a]^T M^-1 [G, a], shape (d + 1, d + 1)."""
    gain: np.ndarray
    """The mean of e by [y, 1], shape (coefficients, d + 1)."""
    root: np.ndarray
    """Rows whose squares are the covariance of e, or M^-1 times F where that follows from M."""
    by_marginal: bool
    """True where the covariance is the prior's less what the samples tell by M."""

    def with_rest(self, known: np.ndarray) -> np.ndarray:
        """Return the covariance of y, then of all curves, by that of y, shape (d, d)."""
        d, root, prior = len(known), self.root, self.fit.prior
        gain = (self.gain + self.fit.shift)[:, :d]
        across, whole = gain @ known, np.empty((d + len(gain),) * 2)
        whole[:d, :d], whole[d:, :d], whole[:d, d:] = known, across, across.T
        apart = np.matmul(root.T, root, out=whole[d:, d:])
        if self.by_marginal:
            np.negative(apart, out=apart)
            add_blocks(apart, prior.block)
        apart += across @ gain.T
        return whole


def given_rest(fit: CurveFit) -> GivenRest:
    """Return the curves by what a fit's samples tell."""
    samples, columns, prior = fit.samples, fit.columns, fit.prior
    if len(columns) <= MOST_SAMPLES:
        along, block = fit.whitened, prior.block
        # the prior's covariance of all coefficients is a block for each joint
        basis = samples.basis.reshape(len(samples.basis), len(block), -1)
        by_joint = np.tensordot(basis, block, axes=(1, 0)).swapaxes(1, 2)
        root = fit.root[0] @ by_joint.reshape(samples.basis.shape)
        return GivenRest(fit, along.T @ along, -root.T @ along, root, by_marginal=True)
    flat = columns.reshape(3 * len(columns), -1)
    weighted = fit.weights[:, None, None] * np.linalg.inv(fit.scales)
    curvature, across = _normal_equations(fit, weighted)
    add_blocks(curvature, prior.inverse)
    root = inverse_root(curvature)
    along = root @ across
    information = flat.T @ (weighted @ columns).reshape(flat.shape) - along.T @ along
    return GivenRest(fit, information, -root.T @ along, root, by_marginal=False)


def _normal_equations(fit: CurveFit, weighted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return F^T W F and F^T W [G, a] of the coefficients of all curves."""
    samples, size = fit.samples, len(fit.shift)
    (places, basis), m = samples.places, samples.readings.shape[1]
    curvature, across = np.zeros(size * size), np.zeros((size, fit.columns.shape[2]))
    for begin in range(0, len(places), BATCH):
        some = slice(begin, begin + BATCH)
        index = places[some].reshape(-1, 4 * m)
        F = (samples.slopes[some][..., None] * basis[some][:, None]).reshape(-1, 3, 4 * m)
        WF = weighted[some] @ F
        np.add.at(across, index, WF.swapaxes(1, 2) @ fit.columns[some])
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
    sockets = np.arange(d - found.centres.size, d)
    if curves is None:
        kept = np.append(np.arange(size), sockets)
        return of_rest[np.ix_(kept, kept)]
    plain = model.with_effects({*model.extensions} - {CURVE.name})
    objective = Objective((plain,), (), SampleRows(scene))
    noises = tuple(found.noises[kind] for _, kind in objective.rows.source_kinds)
    linear = linearise(objective, x, frames)
    state = State(objective, x, found.centres, frames, (), noises, x != x, linear)
    around = samples_around(state, objective.rows, curves[:, None])
    nu = state.degrees
    told = found.weights * (nu + 3) ** 2 / (nu * (nu + 5))
    whole = given_rest(CurveFit(*around, CurvePrior(*scales), told)).with_rest(of_rest)
    picked = np.r_[:size, d : len(whole), sockets]
    return whole[np.ix_(picked, picked)]
