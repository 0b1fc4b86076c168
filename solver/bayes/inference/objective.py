"""The objective L of the default method: its constants, and its samples at some unknowns."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...data import Observations, Pose, distance_covariance
from ...robot import rotation_vectors
from ..model import ExtendedModel, Movement


@dataclass(frozen=True)
class Objective:
    """Constants of all iterations: the model and the data."""

    model: ExtendedModel
    movements: tuple[Movement, ...]
    """Of placements."""
    data: Observations

    @cached_property
    def x_size(self) -> int:
        """Number of unknowns x, of the model and then of movements."""
        return self.model.size + sum(movement.size for movement in self.movements)

    @cached_property
    def dense(self) -> int:
        """Number of unknowns before the socket centres: x, and six for each frame."""
        return self.x_size + 6 * len(self.data.frames)

    @cached_property
    def size(self) -> int:
        """Number n of all unknowns."""
        return self.dense + 3 * self.data.socket_count

    def of_frame(self, k: int) -> slice:
        """Return which unknowns are those of a frame."""
        return slice(self.x_size + 6 * k, self.x_size + 6 * k + 6)

    def of_socket(self, k: int) -> slice:
        """Return which unknowns are those of a socket."""
        return slice(self.dense + 3 * k, self.dense + 3 * k + 3)

    @cached_property
    def by_movements(self) -> np.ndarray:
        """Derivatives of the samples' places by the movements' unknowns, shape (N, 3, U)."""
        none = np.zeros((len(self.data.sockets), 3, 0))
        slopes = (movement.slopes(self.data) for movement in self.movements)
        return np.concatenate([none, *slopes], axis=2)

    def moved_places(self, x: np.ndarray) -> np.ndarray:
        """Return how far the place of each sample has moved, shape (N, 3) [m]."""
        return self.by_movements @ x[self.model.size :]

    @cached_property
    def whiten(self) -> np.ndarray:
        """W, for K measured distances, shape (K, K) [1/m]."""
        return np.linalg.inv(np.linalg.cholesky(distance_covariance(self.data.known)))

    @cached_property
    def nominal_volume(self) -> float:
        """See :meth:`volume`, of the nominal robot."""
        return self.volume(np.zeros(self.x_size))[0]

    def volume(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the last term of L but for a constant, and its slope by all unknowns, (n,)."""
        size, count, slope = self.model.size, self.data.freedom, np.zeros(self.size)
        if not count:
            return 0.0, slope
        log_volume, by_unknowns = self.model.log_volume(x[:size], self.data.positions)
        slope[:size] = -count * by_unknowns
        return -count * log_volume, slope


@dataclass(frozen=True)
class Linearization:
    """The samples at some unknowns, and their derivatives."""

    points: np.ndarray
    """Phi(x, q_i), shape (N, 3) [m]."""
    places: np.ndarray
    """Errors e_i but for the sockets' centres: of a ball in one, its place, shape (N, 3)."""
    by_unknowns: np.ndarray
    """J_i, derivatives of the errors by all unknowns, shape (N, 3, n)."""
    by_joints: np.ndarray
    """Jq_i, derivatives of the ball's position by the joint positions, shape (N, 3, m)."""
    volume: float
    """See :meth:`Objective.volume`."""
    by_volume: np.ndarray

    @cached_property
    def reach(self) -> np.ndarray:
        """Mean square of how far each unknown moves the ball per axis, shape (n,)."""
        return (
            np.einsum("nij,nij->j", self.by_unknowns, self.by_unknowns)
            / self.places.size
        )


def linearise(
    objective: Objective, x: np.ndarray, frames: tuple[Pose, ...]
) -> Linearization:
    """Return the samples and their derivatives at some unknowns."""
    model, data, size = objective.model, objective.data, objective.model.size
    q, torques, clocks = data.positions, data.torques, data.clocks
    J = np.zeros((len(q), 3, objective.size))
    points, J[:, :, :size], by_joints = model.linearise(x[:size], q, torques, clocks)
    places = points.copy()
    for k, frame in enumerate(frames):
        balls, turned, columns = (
            data.measured_in == k,
            data.turned_in == k,
            objective.of_frame(k),
        )
        places[balls] -= frame.apply(data.points[balls])
        J[balls, :, columns] = -frame.slopes(data.points[balls])
        if turned.any():
            R, J[turned, :, :size], by_joints[turned] = model.linearise(
                x[:size], q[turned], torques[turned], clocks[turned], of_turns=True
            )
            poses = frame.rotation @ data.rotations[turned]
            places[turned] = rotation_vectors(R @ poses.swapaxes(1, 2))
            J[turned, :, columns] = -np.eye(3, 6)
    if objective.movements:
        places -= objective.moved_places(x)
        J[:, :, size : objective.x_size] = -objective.by_movements
    for k in range(data.socket_count):
        J[data.sockets == k, :, objective.of_socket(k)] = -np.eye(3)
    return Linearization(points, places, J, by_joints, *objective.volume(x))
