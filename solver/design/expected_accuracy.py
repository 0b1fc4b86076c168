"""Expected accuracy of a calibration: after more recordings, at each place, and joint by joint.

All of it follows from the posterior's covariance, to first order; docs/model.md introduces it.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..bayes.inference import FitPosterior, Posterior, estimate, refit
from ..bayes.model import ExtendedModel, extend
from ..bayes.model.effects import EFFECTS, effects_of
from ..bayes.results import scale, workspace_errors
from ..data import (
    CALIPER_DEVIATION,
    SEAT_DEVIATION,
    STANDARD_LOAD,
    KnownDistance,
    KnownError,
    Load,
    Measurement,
    RobotRecordings,
    SocketSamples,
    as_point,
    observe,
)
from ..paper import NotConverged
from ..results import ErrorMap, JointEffect, Scale
from ..robot import Robot, choose_parameters, workspace
from .information import from_fit, unit

POSES = 2000
"""Random poses of the workspace."""
CELLS = 10
"""Of the map, from the robot's base to the farthest of the balls."""


def predicted_posterior(
    posterior: Posterior, by_socket: Sequence[SocketSamples]
) -> Posterior:
    """Return the posterior of the model after recording the same base at another place.

    The sockets are as far apart as before, but for how the base bends: an error of their distance
    is the same one, and recording more does not make it smaller.
    """
    before = from_fit(posterior)
    first = before.sockets
    after = before.with_sockets(len(by_socket))
    for k, (q, moments) in enumerate(by_socket, first):
        after = after.with_samples(q, k, moments)
    on_base = [length for length in posterior.data.known if length.on_base]
    if on_base and len(by_socket) > 1:
        a, b = on_base[0].first, on_base[0].second
        means = [posterior.predict(*samples).mean(axis=0) for samples in by_socket[:2]]
        u = unit(posterior.centres[b] - posterior.centres[a])
        v = unit(means[1] - means[0])
        ends = {a: u, b: -u, first: -v, first + 1: v}
        after = after.with_lengths(ends, 2**0.5 * SEAT_DEVIATION)
    size = len(before.covariance)
    return replace(posterior, covariance=after.covariance[:size, :size])


WorkspaceSamples = tuple[np.ndarray, np.ndarray]
"""Ball centres in N random poses, shape (N, 3) [m], and their derivatives, (N, 3, size)."""


def workspace_samples(
    model: ExtendedModel, x: np.ndarray, load: Load
) -> WorkspaceSamples:
    """Return the ball in random poses by a model with unknowns x, shape (size,)."""
    q = workspace(model.robot, POSES)
    return model.linearise(x, q, load.moments(model.robot, q, None))[:2]


def error_map(posterior: Posterior, poses: WorkspaceSamples) -> ErrorMap:
    """Return the predicted error of places over the workspace, seen from above.

    No ball shows the base frame itself, so the error of a place is that of its distance from the
    middle of all samples that were trained on: g^T Sigma g with g = u^T (J_p - Jm), u the direction
    from that middle, J_p the derivatives of the place and Jm the mean of the samples'.
    """
    points, by_unknowns = poses
    data = posterior.data
    _, J, _ = posterior.linearise(data.positions, data.torques, data.clocks)
    offsets = points - posterior.points.mean(axis=0)
    distances = np.linalg.norm(offsets, axis=1, keepdims=True)
    directions = offsets / distances.clip(1e-9)
    slopes = np.einsum("ni,nij->nj", directions, by_unknowns - J.mean(axis=0))
    variances = np.sum(slopes @ posterior.of_unknowns * slopes, axis=1)
    from_above = points[:, :2]
    width = float(np.linalg.norm(from_above, axis=1).max()) / CELLS
    corners = np.floor(from_above / width)
    cells, cell = np.unique(corners, axis=0, return_inverse=True)
    cell = cell.ravel()
    medians = [np.median(variances[cell == k]) for k in range(len(cells))]
    rows = np.column_stack([(cells + 0.5) * width, np.sqrt(medians)])
    return ErrorMap(width, tuple(map(as_point, rows)))


def joint_effects(
    model: ExtendedModel,
    x: np.ndarray,
    poses: WorkspaceSamples,
    by_socket: Sequence[SocketSamples],
) -> tuple[JointEffect, ...]:
    """Return the displacements of the ball by the numbers of each joint, and of the ball.

    It is the error that would come back if the calibration left this joint alone: the ball's
    displacement, less its mean in each socket, or over random ``poses``. ``x`` are the model's
    unknowns, shape (size,), and ``by_socket`` is that of :func:`predicted_posterior`.
    """
    owners = [name.rpartition(".")[0] for name in model.names]
    joints = list(dict.fromkeys(owners))
    changes = np.equal.outer(joints, owners) * x

    def squares(J: np.ndarray) -> np.ndarray:
        return np.sum(((J - J.mean(axis=0)) @ changes.T) ** 2, axis=1)

    slopes = [model.linearise(x, *samples)[1] for samples in by_socket]
    recorded = np.concatenate([squares(J) for J in slopes])
    means = [
        np.sqrt(np.mean(part, axis=0)).tolist()
        for part in (recorded, squares(poses[1]))
    ]
    return tuple(map(JointEffect, joints, *means))


class Accuracy(NamedTuple):
    """Expected accuracy of a calibration."""

    distance_deviation: float
    """Median over random poses of the errors of distances, one standard deviation [m]."""
    scale: Scale
    """By how much the arm comes out larger than its model."""


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
    bending = extend(robot, parameters, (*rigid, *twists))
    fits: list[FitPosterior] = []
    with suppress(KnownError, NotConverged):
        arm = RobotRecordings(robot, measurements, load)
        data = observe(arm, lengths=distances, deviation=deviation)
        fits.append(estimate(extend(robot, parameters, rigid), data))
        fits.append(refit(fits[0], bending))
    if not fits:
        return None
    posterior = max(fits, key=lambda fit: fit.log_evidence).arm
    error = workspace_errors(posterior, load).median
    return Accuracy(error, scale(posterior)) if np.isfinite(error) else None
