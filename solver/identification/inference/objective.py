"""The objective L of the default method: its constants, and its samples at some unknowns."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..data import Observations, Pose, distance_covariance
from ..model import Difference, ExtendedModel, Prediction
from ..robot import rotation_vectors


@dataclass(frozen=True)
class Objective:
    """Constants of all iterations: the model and the data."""

    model: ExtendedModel
    differences: tuple[Difference, ...]
    """Between places."""
    data: Observations

    @cached_property
    def x_size(self) -> int:
        """Number of unknowns x, of the model and then of differences."""
        return self.model.size + sum(self.sizes)

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
        begin = self.x_size + 6 * k
        return slice(begin, begin + 6)

    def of_socket(self, k: int) -> slice:
        """Return which unknowns are those of a socket."""
        begin = self.dense + 3 * k
        return slice(begin, begin + 3)

    @cached_property
    def cells(self) -> list[np.ndarray]:
        """Indices of the unknowns of sockets that measured distances tie, a cell for each tie."""
        cells = np.arange(self.data.socket_count)
        for length in self.data.known:
            cells[cells == cells[length.second]] = cells[length.first]
        of_centres = np.repeat(cells, 3)
        return [self.dense + np.flatnonzero(of_centres == k) for k in np.unique(cells)]

    @cached_property
    def _slopes(self) -> list[np.ndarray]:
        """Derivatives of the samples' places by the unknowns of each difference, (N, 3, size)."""
        return [d.slopes(self.model, self.data) for d in self.differences]

    @cached_property
    def sizes(self) -> list[int]:
        """Number of each difference's unknowns."""
        return [slopes.shape[2] for slopes in self._slopes]

    @cached_property
    def by_differences(self) -> np.ndarray:
        """Derivatives of the samples' places by all differences' unknowns, shape (N, 3, U)."""
        N = len(self.data.sockets)
        return np.concatenate([np.zeros((N, 3, 0)), *self._slopes], axis=2)

    @cached_property
    def put_on_anew(self) -> np.ndarray:
        """True for unknowns of differences of a ball that was put on anew, shape (U,)."""
        each = [d.course == "each" for d in self.differences]
        return np.repeat(np.array(each, bool), self.sizes)

    @cached_property
    def to_links(self) -> np.ndarray:
        """Rotations into the nominal ball's link, by which its differences are, (N, 3, 3)."""
        ball = self.model.ball
        R = ball.rotations(ball.nominal, self.data.q).points
        return R.swapaxes(1, 2)

    @cached_property
    def whiten(self) -> np.ndarray:
        """W, for K measured distances, shape (K, K) [1/m]."""
        C = distance_covariance(self.data.known)
        root = np.linalg.cholesky(C)
        return np.linalg.inv(root)

    @cached_property
    def nominal_volume(self) -> float:
        """See :meth:`volume`, of the nominal robot."""
        x = np.zeros(self.x_size)
        return self.volume(x).value

    def volume(self, x: np.ndarray) -> "VolumeTerm":
        """Return the last term of L, - (N - S) times the mean of log V_i, but for a constant."""
        slope = np.zeros(self.size)
        freedom = self.data.freedom
        if not freedom:
            return VolumeTerm(0.0, slope)
        log_volume, by_unknowns = self.model.log_volume(x, self.data.q)
        slope[: self.model.size] = -freedom * by_unknowns
        return VolumeTerm(-freedom * log_volume, slope)


class VolumeTerm(NamedTuple):
    """The last term of L, which holds the robot's size."""

    value: float
    slope: np.ndarray
    """By all unknowns, shape (n,)."""


@dataclass(frozen=True)
class Linearization:
    """The samples at some unknowns, and their derivatives."""

    points: np.ndarray
    """Phi(x, q_i), shape (N, 3) [m]."""
    places: np.ndarray
    """Errors e_i but for the sockets' centres: of a ball in one, its place, shape (N, 3)."""
    by_unknowns: np.ndarray
    """A_i, derivatives of the errors by all unknowns but the sockets' centres, shape (N, 3, d).

    By that of its own socket, the error of a sample has the derivative -1."""
    by_joints: np.ndarray
    """Jq_i, derivatives of the ball's position by the joint positions, shape (N, 3, m)."""
    volume: VolumeTerm
    """See :meth:`Objective.volume`."""

    @cached_property
    def reach(self) -> np.ndarray:
        """Mean square of how far each of these moves the ball per axis, shape (d,)."""
        A = self.by_unknowns
        squares: np.ndarray = np.einsum("nij,nij->j", A, A)
        return squares / self.places.size


def linearise(
    objective: Objective,
    x: np.ndarray,
    frames: tuple[Pose, ...],
) -> Linearization:
    """Return the samples and their derivatives at some unknowns.

    The error Phi(x, q_i) - m_s(i) has the derivatives [dPhi/dx, -dm/du, 0] by the model's unknowns
    x, those of differences u, and frames. A measured ball has -F y in place of the socket, a
    measured orientation the rotation vector from F R_y to that of its link.
    """
    model, data = objective.model, objective.data
    size, N = model.size, len(data.q)
    A = np.zeros((N, 3, objective.dense))
    balls = model.linearise(x, data)
    places = balls.points.copy()
    A[:, :, :size] = balls.by_unknowns
    by_joints = balls.by_joints
    for k, frame in enumerate(frames):
        of_frame = objective.of_frame(k)
        in_frame = data.measured_in == k
        coordinates = data.points[in_frame]
        places[in_frame] -= frame.apply(coordinates)
        A[in_frame, :, of_frame] = -frame.slopes(coordinates)
        turned = data.turned_in == k
        if turned.any():
            turns = _turns_in_frame(objective, x, frame, turned)
            places[turned] = turns.points
            A[turned, :, :size] = turns.by_unknowns
            A[turned, :, of_frame] = -np.eye(3, 6)
            by_joints[turned] = turns.by_joints
    if objective.differences:
        of_differences = slice(size, objective.x_size)
        A[:, :, of_differences] = -objective.by_differences
        if objective.put_on_anew.any():
            _turn_with_links(objective, x, A, by_joints)
        places += A[:, :, of_differences] @ x[of_differences]
    volume = objective.volume(x)
    return Linearization(balls.points, places, A, by_joints, volume)


def _turn_with_links(
    objective: Objective, x: np.ndarray, A: np.ndarray, by_joints: np.ndarray
) -> None:
    """Let balls that were put on anew turn with their links, in derivatives that change in place.

    Of one R s from where it was, an unknown that turns the link by t has the derivative t x (R s).
    """
    size, anew = objective.model.size, objective.put_on_anew
    links = objective.model.linearise(x, objective.data, of_turns=True)
    D = A[:, :, size : objective.x_size]
    D[:] = np.where(anew, links.points @ objective.to_links @ D, D)
    shifts = (D @ (anew * x[size:]))[:, :, None]
    A[:, :, :size] += np.cross(links.by_unknowns, shifts, axis=1)
    by_joints += np.cross(links.by_joints, shifts, axis=1)


def _turns_in_frame(
    objective: Objective,
    x: np.ndarray,
    frame: Pose,
    rows: np.ndarray,
) -> Prediction:
    """Return rotation vectors from measured orientations to the link's, and their derivatives."""
    model, data = objective.model, objective.data
    samples = data.only(rows)
    links = model.linearise(x, samples, of_turns=True)
    measured_rotations = frame.rotation @ samples.rotations
    errors = links.points @ measured_rotations.swapaxes(1, 2)
    return links._replace(points=rotation_vectors(errors))
