"""Error curves of which a prior tells already, together with other unknowns of a robot."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...data import MultiRobotObservations, Pose
from ..model import ExtendedModel, extend
from ..model.effects import CURVE, KNOTS
from .curve_marginal import CurvePrior
from .curve_posterior import curvature_of
from .linear_samples import LinearSamples, Rest, linear_samples, with_curves
from .objective import State, build_objective, linearise
from .posterior import Posterior


@dataclass(frozen=True)
class GivenCurves:
    """What a prior tells of one robot's curves; coefficients joint after joint."""

    mean: np.ndarray
    """mu_c at x = mu_x, shape (m KNOTS,) [rad]."""
    known: np.ndarray
    """mu_x, shape (size,)."""
    by_unknowns: np.ndarray
    """R, shape (m KNOTS, size); zero for what the prior does not tell of."""
    covariance: np.ndarray
    """Of e, shape (m KNOTS, m KNOTS)."""
    scales: tuple[float, float]
    """Amplitude and length of the process that the curves were of at first [rad]."""

    def at(self, x: np.ndarray) -> np.ndarray:
        """Return the most probable curves beside other unknowns, shape (m, KNOTS) [rad]."""
        return (self.mean + self.by_unknowns @ (x[: len(self.known)] - self.known)).reshape(
            -1, KNOTS
        )

    def relative(self, samples: LinearSamples, x: np.ndarray) -> LinearSamples:
        """Return samples whose curves are e alone, around a state x of the other unknowns."""
        by_rest = samples.by_rest.copy()
        by_rest[:, :, : len(self.known)] += samples.basis @ self.by_unknowns
        errors = samples.errors + samples.basis @ self.at(x).ravel()
        return replace(samples, errors=errors, by_rest=by_rest, given=self.covariance)

    def whole(self, covariance: np.ndarray) -> np.ndarray:
        """Return the covariance of y and c from that of y and e."""
        d, size = len(covariance) - len(self.mean), self.by_unknowns.shape[1]
        turned = np.eye(len(covariance))
        turned[d:, :size] = self.by_unknowns
        return turned @ covariance @ turned.T


def given_curves(models: Sequence[ExtendedModel]) -> GivenCurves | None:
    """Return what the prior of a single robot tells of its curves; None for nothing."""
    model = models[0]
    if len(models) > 1 or model.given is None:
        return None
    joints = model.robot.joint_names
    each = CURVE.coefficient_names(joints)
    names = [each[k * len(joints) + j] for j in range(len(joints)) for k in range(KNOTS)]
    if not {*names} & {*model.given.names}:
        return None
    own = model.given.of(names)
    others = model.given.of(model.names)
    both = model.given.of([*own.names, *others.names])
    n, place = len(own.names), {name: i for i, name in enumerate(names)}
    S = both.covariance
    unit = 1 / np.sqrt(np.diag(S)[n:])
    by_others = S[:n, n:] * unit @ np.linalg.inv(S[n:, n:] * unit[:, None] * unit) * unit
    rows = [place[name] for name in own.names]
    columns = [model.names.index(name) for name in others.names]
    mean, known = np.zeros(len(names)), np.zeros(model.size)
    mean[rows], known[columns] = own.mean, others.mean
    by_unknowns = np.zeros((len(names), model.size))
    by_unknowns[np.ix_(rows, columns)] = by_others
    covariance = np.zeros((len(names), len(names)))
    covariance[np.ix_(rows, rows)] = S[:n, :n] - by_others @ S[n:, :n]
    return GivenCurves(mean, known, by_unknowns, covariance, model.given.curve_scales)


def restored_covariance(
    found: Posterior,
    scene: MultiRobotObservations,
    frames: tuple[Pose, ...],
    scales: tuple[float, float],
) -> np.ndarray:
    """Return the covariance of a robot's unknowns and sockets from that of all but its curves.

    Given the other unknowns y, the curves c are Gaussian: c = A y + e, with A = -H_cc^-1 H_cy and
    e ~ N(0, H_cc^-1), where H is the samples' curvature with the curves' prior.

    Args:
        found: The result, with the covariance of y: the unknowns but for curves, the frames, the
            sockets.
        scene: What it was fitted to.
        frames: Poses of the instruments' frames.
        scales: Amplitude and length of the curves [rad]; zero without any.
    """
    model, size, of_rest = found.model, found.model.scalars, found.covariance
    names = [e for e in model.extensions if e != CURVE.name]
    rest = extend(model.robot, model.parameters, names)
    curves, x, d = (
        found.x[size:].reshape(-1, len(model.robot.joint_names)),
        found.x[:size],
        len(of_rest),
    )
    kept = np.r_[:size, d - found.centres.size : d]
    if not curves.size:
        return of_rest[np.ix_(kept, kept)]
    objective, shifts = with_curves(build_objective([rest], scene), curves.T[None])
    noises = tuple(found.noises[kind] for _, kind in objective.rows.source_kinds)
    linear = linearise(objective, x, found.centres, frames)
    state = State(x, found.centres, frames, (), noises, x != x, linear)
    samples = linear_samples(objective, state, shifts)
    nu = samples.degrees(noises)
    told = found.weights * (nu + 3) ** 2 / (nu * (nu + 5))
    inverse = np.linalg.inv(samples.scales(noises)) * told[:, None, None]
    nothing = Rest(np.zeros((d, d)), np.zeros(d), np.full(d, fill_value=True))
    H, _ = curvature_of(samples, CurvePrior(*scales), nothing, inverse)
    apart = np.linalg.inv(H[d:, d:])
    gain = -apart @ H[d:, :d]
    of_curves = apart + gain @ of_rest @ gain.T
    whole = np.block([[of_rest, of_rest @ gain.T], [gain @ of_rest, of_curves]])
    order = d + np.arange(curves.size).reshape(curves.shape[::-1]).T.ravel()
    picked = np.r_[:size, order, kept[size:]]
    return whole[np.ix_(picked, picked)]
