"""The objective L of the default method: its constants, and its samples at some unknowns."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ...data import Pose, distance_covariance
from ...robot import rotation_vectors
from ..model import ExtendedModel, Movement, SampleRows


@dataclass(frozen=True)
class Objective:
    """Constants of all iterations: the models and the data."""

    models: tuple[ExtendedModel, ...]
    movements: tuple[Movement, ...]
    """Of placements."""
    rows: SampleRows

    @cached_property
    def own(self) -> tuple[slice, ...]:
        """For each robot, which of x are its unknowns."""
        ends = np.cumsum([0, *(model.size for model in self.models)]).tolist()
        return tuple(slice(a, b) for a, b in pairwise(ends))

    @cached_property
    def model_size(self) -> int:
        """Number of unknowns of all robots and movements."""
        return sum(part.size for part in (*self.models, *self.movements))

    @cached_property
    def dense(self) -> int:
        """Number of unknowns before the socket centres: x, and six for each frame."""
        return self.model_size + 6 * len(self.rows.every.frames)

    @cached_property
    def size(self) -> int:
        """Number n of all unknowns."""
        return self.dense + 3 * self.rows.every.socket_count

    def of_frame(self, k: int) -> slice:
        """Return which unknowns are those of a frame."""
        return slice(self.model_size + 6 * k, self.model_size + 6 * k + 6)

    def of_socket(self, k: int) -> slice:
        """Return which unknowns are those of a socket."""
        return slice(self.dense + 3 * k, self.dense + 3 * k + 3)

    @cached_property
    def by_movements(self) -> np.ndarray:
        """Derivatives of the samples' places by the movements' unknowns, shape (N, 3, U)."""
        none = np.zeros((len(self.rows.every.sockets), 3, 0))
        slopes = (movement.slopes(self.rows.scene) for movement in self.movements)
        return np.concatenate([none, *slopes], axis=2)

    def moved_places(self, x: np.ndarray) -> np.ndarray:
        """Return how far the place of each sample has moved, shape (N, 3) [m]."""
        return self.by_movements @ x[self.own[-1].stop :]

    @cached_property
    def whiten(self) -> np.ndarray:
        """W, for K measured distances, shape (K, K) [1/m]."""
        return np.linalg.inv(np.linalg.cholesky(distance_covariance(self.rows.every.known)))

    @cached_property
    def nominal_volume(self) -> float:
        """See :meth:`volume`, of the nominal robots."""
        return self.volume(np.zeros(self.model_size))[0]

    def volume(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the last term of L but for a constant, and its slope by all unknowns, (n,)."""
        total, slope = 0.0, np.zeros(self.size)
        robots = zip(self.own, self.models, self.rows.scene.arms, self.rows.volumes, strict=True)
        for members, model, arm, count in robots:
            if count:
                log_volume, by_unknowns = model.log_volume(x[members], arm.positions)
                slope[members] = -count * by_unknowns
                total -= count * log_volume
        return total, slope


@dataclass(frozen=True)
class Linearization:
    """The samples at some unknowns, and their derivatives."""

    points: np.ndarray
    """Phi(x, q_i), each in its own robot's base, shape (N, 3) [m]."""
    places: np.ndarray
    """Errors e_i but for the sockets' centres: of a ball in one, its place in the world, (N, 3)."""
    by_unknowns: np.ndarray
    """J_i, derivatives of the errors by x and the frames, shape (N, 3, dense)."""
    by_joints: np.ndarray
    """Jq_i, derivatives of the ball's position by the joint positions, shape (N, 3, m); of several
    robots, m is the largest number of joints."""
    volume: float
    """See :meth:`Objective.volume`."""
    by_volume: np.ndarray

    @cached_property
    def reach(self) -> np.ndarray:
        """Mean square of how far each unknown moves the ball per axis, shape (dense,)."""
        return np.einsum("nij,nij->j", self.by_unknowns, self.by_unknowns) / self.places.size


def linearise(objective: Objective, x: np.ndarray, frames: tuple[Pose, ...]) -> Linearization:
    """Return the samples and their derivatives at some unknowns."""
    rows, sample_rows = objective.rows, objective.rows.every
    n, widest = len(sample_rows.sockets), max(arm.positions.shape[1] for arm in rows.scene.arms)
    points, places, rotations = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3, 3))
    J, by_joints = np.zeros((n, 3, objective.dense)), np.zeros((n, 3, widest))
    arms = zip(objective.own, rows.own, objective.models, rows.scene.arms, strict=True)
    for i, (members, samples, model, arm) in enumerate(arms):
        q, torques, m = arm.positions, arm.torques, arm.positions.shape[1]
        points[samples], J[samples, :, members], by_joints[samples, :, :m] = model.linearise(
            x[members], q, torques, arm.clocks
        )
        places[samples] = points[samples]
        turned = samples.start + np.flatnonzero(arm.turned)
        if len(turned):
            rotations[turned], J[turned, :, members], by_joints[turned, :, :m] = model.linearise(
                x[members],
                q[arm.turned],
                torques[arm.turned],
                arm.clocks[arm.turned],
                of_turns=True,
            )
        base = rows.base(i, frames)
        if base is not None:
            of_base = objective.of_frame(rows.scene.bases[i])
            places[samples] = base.apply(points[samples])
            J[samples, :, members] = base.rotation @ J[samples, :, members]
            J[samples, :, of_base] = base.slopes(points[samples])
            J[turned, :, of_base] = np.eye(3, 6)
            by_joints[samples] = base.rotation @ by_joints[samples]
            rotations[turned] = base.rotation @ rotations[turned]
    for k, frame in enumerate(frames):
        measured, turned = sample_rows.measured_in == k, sample_rows.turned_in == k
        poses = frame.rotation @ sample_rows.rotations[turned]
        places[measured] -= frame.apply(sample_rows.points[measured])
        places[turned] = rotation_vectors(rotations[turned] @ poses.swapaxes(1, 2))
        J[measured, :, objective.of_frame(k)] = -frame.slopes(sample_rows.points[measured])
        J[turned, :, objective.of_frame(k)] = -np.eye(3, 6)
    if objective.movements:
        places -= objective.moved_places(x)
        J[:, :, objective.own[-1].stop : objective.model_size] = -objective.by_movements
    return Linearization(points, places, J, by_joints, *objective.volume(x))
