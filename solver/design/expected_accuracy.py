"""Expected accuracy of a calibration: after more recordings, at each place, and joint by joint.

All of it follows from the posterior's covariance, to first order; docs/model.md introduces it.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ...errors import NotConverged
from ..identification.data import (
    CALIPER_DEVIATION,
    SEAT_DEVIATION,
    STANDARD_LOAD,
    KnownDistance,
    KnownError,
    Load,
    Measurement,
    RobotRecordings,
    Samples,
    as_point,
    is_distorted,
    observe,
)
from ..identification.effects import EFFECTS, effects_of
from ..identification.inference import FitPosterior, Posterior, estimate, refit
from ..identification.model import ExtendedModel, Prediction, extend
from ..identification.robot import Robot, choose_parameters, workspace
from ..results import Better, ErrorMap, JointEffect, Scale
from ..studies import (
    Models,
    better_than_nominal,
    scale,
    unit,
    variances_of,
    workspace_errors,
)
from .information import from_fit

POSES = 2000
"""Random poses of the workspace."""
CELLS = 10
"""Of the map, from the robot's base to the farthest of the balls."""


def predicted_posterior(
    posterior: Posterior,
    by_socket: Sequence[Samples],
) -> Posterior:
    """Return the posterior of the model after recording the same base at another place.

    The sockets are as far apart as before, but for how the base bends: an error of their distance
    is the same one, and recording more does not make it smaller.
    """
    before = from_fit(posterior)
    first = before.sockets
    after = before.with_sockets(len(by_socket))
    for k, samples in enumerate(by_socket, first):
        after = after.with_samples(samples, k)
    on_base = [length for length in posterior.data.known if length.on_base]
    if on_base and len(by_socket) > 1:
        a = on_base[0].first
        b = on_base[0].second
        u = unit(posterior.centres[b] - posterior.centres[a])
        balls = [posterior.predict(samples) for samples in by_socket[:2]]
        means = [points.mean(axis=0) for points in balls]
        v = unit(means[1] - means[0])
        ends = {a: u, b: -u, first: -v, first + 1: v}
        after = after.with_lengths(ends, 2**0.5 * SEAT_DEVIATION)
    size = len(before.covariance)
    return replace(posterior, covariance=after.covariance[:size, :size])


def workspace_samples(
    model: ExtendedModel,
    x: np.ndarray,
    load: Load,
) -> Prediction:
    """Return balls in random poses by a model with unknowns x, shape (size,), and derivatives."""
    q = workspace(model.robot, POSES)
    return model.linearise(x, load.at(model.robot, q))


def error_map(
    posterior: Posterior,
    poses: Prediction,
) -> ErrorMap:
    """Return the predicted error of places over the workspace, seen from above.

    No ball shows the base frame itself, so the error of a place is that of its distance from the
    middle of all samples that were trained on: g^T Sigma g with g = u^T (J_p - Jm), u the direction
    from that middle, J_p the derivatives of the place and Jm the mean of the samples'.
    """
    _, J, _ = posterior.linearise(posterior.data)
    middle = posterior.points.mean(axis=0)
    by_offsets = poses.by_unknowns - J.mean(axis=0)
    slopes = np.einsum("ni,nij->nj", unit(poses.points - middle), by_offsets)
    variances = variances_of(slopes, posterior.of_unknowns)
    from_above = poses.points[:, :2]
    width = float(np.linalg.norm(from_above, axis=1).max()) / CELLS
    corners = np.floor(from_above / width)
    cells, cell = np.unique(corners, axis=0, return_inverse=True)
    cell = cell.ravel()
    deviations = [np.median(variances[cell == k]) ** 0.5 for k in range(len(cells))]
    rows = np.column_stack([(cells + 0.5) * width, deviations])
    return ErrorMap(width, tuple(map(as_point, rows)))


def joint_effects(
    model: ExtendedModel,
    x: np.ndarray,
    poses: Prediction,
    by_socket: Sequence[Samples],
) -> tuple[JointEffect, ...]:
    """Return the displacements of the ball by the numbers of each joint, and of the ball.

    It is the error that would come back if the calibration left this joint alone: the ball's
    displacement, less its mean in each socket, or over random ``poses``. ``x`` are the model's
    unknowns, shape (size,), and ``by_socket`` is that of :func:`predicted_posterior`.
    """
    owners = [name.rpartition(".")[0] for name in model.names]
    joints = list(dict.fromkeys(owners))
    changes = np.equal.outer(joints, owners) * x

    def squares(balls: Prediction) -> np.ndarray:
        J = balls.by_unknowns
        displacements = (J - J.mean(axis=0)) @ changes.T
        return np.sum(displacements**2, axis=1)

    recorded = [squares(model.linearise(x, samples)) for samples in by_socket]
    at_samples = np.concatenate(recorded).mean(axis=0)
    anywhere = squares(poses).mean(axis=0)
    columns = np.sqrt([at_samples, anywhere]).tolist()
    return tuple(map(JointEffect, joints, *columns))


class Accuracy(NamedTuple):
    """Expected accuracy of a calibration."""

    distance_deviation: float
    """Median over random poses of the errors of distances, one standard deviation [m]."""
    scale: Scale
    """By how much the arm comes out larger than its model."""
    length: float | None
    """Median of those distances [m]."""
    better: Better
    """Errors of distances by the nominal model and by the calibrated one."""
    distorted: bool
    """True where the fit does not reproduce the distance of sockets: it tells no size then."""


def accuracy_by(
    robot: Robot,
    measurements: Sequence[Measurement],
    load: Load = STANDARD_LOAD,
    distances: Sequence[KnownDistance] = (),
    deviation: float = CALIPER_DEVIATION,
    *,
    zeros: bool = False,
) -> Accuracy | None:
    """Return the accuracy of a calibration on recordings; None where no fit settles.

    The arm may bend: one that bends, and is taken for a rigid one, comes out too long.
    """
    parameters = choose_parameters(robot)
    rigid = effects_of(zeros=zeros)
    twists = [e.name for e in EFFECTS.values() if e.elastic and not e.across]
    rigid_model = extend(robot, parameters, rigid)
    bending_model = extend(robot, parameters, (*rigid, *twists))
    fits: list[FitPosterior] = []
    with suppress(KnownError, NotConverged):
        data = observe(
            RobotRecordings(robot, measurements, load),
            lengths=distances,
            deviation=deviation,
        )
        fits.append(estimate(rigid_model, data))
        fits.append(refit(fits[0], bending_model))
    if not fits:
        return None
    arm = max(fits, key=lambda fit: fit.log_evidence).arm
    errors = workspace_errors(arm, load)
    if not np.isfinite(errors.median):
        return None
    better = _better(arm, load, measurements)
    distorted = any(
        is_distorted(arm.predict(load.samples(robot, m)), m) for m in measurements
    )
    return Accuracy(errors.median, scale(arm), errors.length, better, distorted)


def _better(
    posterior: Posterior, load: Load, recorded: Sequence[Measurement]
) -> Better:
    """Return the errors of distances by the nominal model, its ball put right, and by the fit."""
    model = posterior.model
    of_ball = np.array([p.of_ball for p in model.parameters])
    nominal = np.where(of_ball, posterior.values, model.ball.nominal)

    models = Models(
        [partial(model.ball.points, nominal)],
        lambda q: posterior.predict(load.at(model.robot, q)),
        corrected=False,
    )
    return better_than_nominal(posterior, load, models, recorded)
