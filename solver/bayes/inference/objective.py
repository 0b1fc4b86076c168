"""The objective L of the default method: its constants, and its errors at some unknowns."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ...data import MultiRobotObservations, Pose, rotation_vectors
from ..model import ExtendedModel, Movement, SampleRows

Balls = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Balls, each in its own robot's base, the errors' derivatives there by x and the frames, and by
the joints, and the rotations of the balls' links where they were measured, shape (N, 3, 3)."""


@dataclass(frozen=True)
class Objective:
    """Constants of all iterations: the model, the data, and two terms of L."""

    models: tuple[ExtendedModel, ...]
    movements: tuple[Movement, ...]
    """Of placements."""
    rows: SampleRows
    nominal_log_volumes: tuple[float, ...]
    """Mean of log V_i of each nominal robot."""
    whiten: np.ndarray
    """W, for K measured distances, shape (K, K) [1/m]."""

    @cached_property
    def own(self) -> tuple[slice, ...]:
        """For each robot, which of x are its unknowns."""
        ends = np.cumsum([0, *(model.size for model in self.models)]).tolist()
        return tuple(slice(a, b) for a, b in pairwise(ends))

    @cached_property
    def model_size(self) -> int:
        """Number of unknowns of all robots and movements."""
        return sum(one.size for one in (*self.models, *self.movements))

    @cached_property
    def dense(self) -> int:
        """Number of unknowns before the socket centres: x, and six for each frame."""
        return self.model_size + 6 * self.rows.frame_count

    @cached_property
    def by_movements(self) -> np.ndarray:
        """Derivatives of the samples' places by the movements' unknowns, shape (N, 3, U)."""
        scene = self.rows.scene
        none = np.zeros((len(self.rows.sockets), 3, 0))
        return np.concatenate([none, *(one.slopes(scene) for one in self.movements)], axis=2)

    def moved_places(self, x: np.ndarray) -> np.ndarray:
        """Return how far the place of each sample has moved, shape (N, 3) [m]."""
        return self.by_movements @ x[self.own[-1].stop :]

    @cached_property
    def size(self) -> int:
        """Number n of all unknowns."""
        return self.dense + 3 * self.rows.socket_count

    def of_frame(self, k: int) -> slice:
        """Return which unknowns are those of a frame."""
        return slice(self.model_size + 6 * k, self.model_size + 6 * k + 6)

    def of_socket(self, k: int) -> slice:
        """Return which unknowns are those of a socket."""
        return slice(self.dense + 3 * k, self.dense + 3 * k + 3)


@dataclass(frozen=True)
class Linearization:
    """The samples' errors at some unknowns, and their derivatives."""

    points: np.ndarray
    """Phi(x, q_i), each in its own robot's base, shape (N, 3) [m]."""
    errors: np.ndarray
    """e_i, shape (N, 3) [m]."""
    by_unknowns: np.ndarray
    """J_i, derivatives of the errors by x and the frames, shape (N, 3, dense)."""
    by_joints: np.ndarray
    """Jq_i, derivatives of the ball's position by the joint positions, shape (N, 3, m); of several
    robots, m is the largest number of joints."""
    volume: float
    """The last term of L."""
    by_volume: np.ndarray
    """Its derivatives by all unknowns, shape (n,)."""

    @cached_property
    def reach(self) -> np.ndarray:
        """Mean square of how far each unknown moves the ball per axis, shape (dense,)."""
        return np.einsum("nij,nij->j", self.by_unknowns, self.by_unknowns) / self.errors.size


def build_objective(
    models: Sequence[ExtendedModel],
    data: MultiRobotObservations,
    movements: Sequence[Movement] = (),
) -> Objective:
    """Return the objective of one robot or several."""
    log_volumes = tuple(
        one.log_volume(np.zeros(one.size), arm.positions)[0]
        for one, arm in zip(models, data.arms, strict=True)
    )
    whiten = np.linalg.inv(np.linalg.cholesky(data.arms[0].distance_covariance()))
    return Objective(tuple(models), tuple(movements), SampleRows(data), log_volumes, whiten)


def linearise(
    objective: Objective,
    x: np.ndarray,
    centres: np.ndarray,
    frames: tuple[Pose, ...] = (),
    balls: Balls | None = None,
) -> Linearization:
    """Return the samples' errors and their derivatives at some unknowns; uses up the balls."""
    rows = objective.rows
    points, J, by_joints, rotations = balls or predict_balls(objective, x)
    errors = np.array(to_world(objective, frames, points))
    errors[rows.seated] -= centres[rows.sockets[rows.seated]]
    for i, (own, samples) in enumerate(zip(objective.own, rows.own, strict=True)):
        base = rows.base(i, frames)
        if base is not None:
            of_base = objective.of_frame(rows.scene.bases[i])
            J[samples, :, own] = base.rotation @ J[samples, :, own]
            J[samples, :, of_base] = base.slopes(points[samples])
            J[samples.start + np.flatnonzero(rows.turned[samples]), :, of_base] = np.eye(3, 6)
            by_joints[samples] = base.rotation @ by_joints[samples]
            rotations[samples] = base.rotation @ rotations[samples]
    for k, frame in enumerate(frames):
        measured, turned = rows.measured_in == k, rows.turned_in == k
        errors[measured] -= frame.apply(rows.points[measured])
        placed = frame.rotation @ rows.rotations[turned]
        errors[turned] = rotation_vectors(rotations[turned] @ placed.swapaxes(1, 2))
        J[measured, :, objective.of_frame(k)] = -frame.slopes(rows.points[measured])
        J[turned, :, objective.of_frame(k)] = -np.eye(3, 6)
    if objective.movements:
        errors -= objective.moved_places(x)
    volume, by_volume = 0.0, np.zeros(objective.size)
    for i, (own, one) in enumerate(zip(objective.own, objective.models, strict=True)):
        count = rows.volumes[i]
        if count:
            log_volume, slope = one.log_volume(x[own], rows.scene.arms[i].positions)
            by_volume[own] = -count * slope
            volume -= count * (log_volume - objective.nominal_log_volumes[i])
    return Linearization(points, errors, J, by_joints, volume, by_volume)


def predict_balls(objective: Objective, x: np.ndarray) -> Balls:
    """Return all balls, with the derivatives of what was measured of them."""
    rows, n = objective.rows, len(objective.rows.sockets)
    widest = max(arm.positions.shape[1] for arm in rows.scene.arms)
    points, rotations = np.empty((n, 3)), np.tile(np.eye(3), (n, 1, 1))
    J, by_joints = np.zeros((n, 3, objective.dense)), np.zeros((n, 3, widest))
    arms = zip(objective.own, rows.own, objective.models, rows.scene.arms, strict=True)
    for own, samples, one, arm in arms:
        q, torques, m = arm.positions, arm.torques, arm.positions.shape[1]
        points[samples], J[samples, :, own], by_joints[samples, :, :m] = one.linearise(
            x[own], q, torques
        )
        if arm.turned.any():
            there = samples.start + np.flatnonzero(arm.turned)
            rotations[there], J[there, :, own], by_joints[there, :, :m] = one.linearise(
                x[own], q[arm.turned], torques[arm.turned], of_turns=True
            )
    J[:, :, objective.own[-1].stop : objective.model_size] = -objective.by_movements
    return points, J, by_joints, rotations


def to_world(objective: Objective, frames: tuple[Pose, ...], points: np.ndarray) -> np.ndarray:
    """Return balls in the world instead of each in its own robot's base, shape (N, 3) [m]."""
    bases = [objective.rows.base(i, frames) for i in range(len(objective.models))]
    parts = [
        points[rows] if base is None else base.apply(points[rows])
        for rows, base in zip(objective.rows.own, bases, strict=True)
    ]
    return np.concatenate(parts) if len(parts) > 1 else parts[0]
