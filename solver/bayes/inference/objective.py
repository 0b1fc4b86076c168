"""The objective L of the default method, and the state of the search."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...data import WORLD, MultiRobotObservations, Observations, Pose, rotation_vectors
from ..model import ExtendedModel, Movement, MultiRobotModel, Noise, PriorGroup, SampleRows

Balls = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Balls, each in its own robot's base, the errors' derivatives there by x and by the joints, and
the rotations of the balls' links where they were measured, shape (N, 3, 3)."""
FRAME_PRIOR_PRECISION = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])
"""A weak prior, in 1/rad and 1/m, for frames that the data do not hold: one step then turns a frame
by 1 rad at most, and shifts it by 10 m."""


@dataclass(frozen=True)
class Objective:
    """Constants of all iterations: the model, the data, and two terms of L."""

    model: MultiRobotModel
    rows: SampleRows
    nominal_log_volumes: tuple[float, ...]
    """Mean of log V_i of each nominal robot."""
    whiten: np.ndarray
    """W, for K measured distances, shape (K, K) [1/m]."""

    @cached_property
    def dense(self) -> int:
        """Number of unknowns before the socket centres: x, and six for each frame."""
        return self.model.size + 6 * self.rows.frame_count

    @cached_property
    def by_movements(self) -> np.ndarray:
        """Derivatives of the samples' places by the movements' unknowns, shape (N, 3, U)."""
        scene = self.rows.scene
        none = np.zeros((len(self.rows.sockets), 3, 0))
        return np.concatenate([none, *(one.slopes(scene) for one in self.model.movements)], axis=2)

    def moved_places(self, x: np.ndarray) -> np.ndarray:
        """Return how far the place of each sample has moved, shape (N, 3) [m]."""
        return self.by_movements @ x[self.model.own[-1].stop :]

    @cached_property
    def size(self) -> int:
        """Number n of all unknowns."""
        return self.dense + 3 * self.rows.socket_count


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


@dataclass(frozen=True)
class State:
    """State of the estimation between two iterations."""

    x: np.ndarray
    """Unknowns of the model, shape (size,)."""
    centres: np.ndarray
    """Centres of the sockets in the world, shape (S, 3) [m]."""
    frames: tuple[Pose, ...]
    """Poses of the frames in the world."""
    groups: tuple[PriorGroup, ...]
    """The priors, at their present widths."""
    noises: tuple[Noise, ...]
    """The noise of each source of samples, at its present size; see :attr:`.SampleRows.sources`."""
    at_zero: np.ndarray
    """True where x is held at zero, shape (size,)."""
    linear: Linearization
    """Errors and derivatives at x and the centres."""


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
    model = MultiRobotModel(tuple(models), tuple(movements))
    return Objective(model, SampleRows(data), log_volumes, whiten)


def linearise(
    objective: Objective,
    x: np.ndarray,
    centres: np.ndarray,
    frames: tuple[Pose, ...] = (),
    balls: Balls | None = None,
) -> Linearization:
    """Return the samples' errors and their derivatives at some unknowns."""
    model, rows = objective.model, objective.rows
    balls = balls or predict_balls(objective, x)
    points = balls[0]
    errors, by_x, by_joints = _errors(objective, balls, centres, frames)
    if model.movements:
        at, errors = model.own[-1].stop, errors - objective.moved_places(x)
        parts = (by_x[:, :, :at], -objective.by_movements, by_x[:, :, at:])
        by_x = np.concatenate(parts, axis=2)
    by_x, by_joints = np.ascontiguousarray(by_x), np.ascontiguousarray(by_joints)  # far faster
    volume, by_volume = 0.0, np.zeros(objective.size)
    for i, (own, one) in enumerate(zip(model.own, model.models, strict=True)):
        count = rows.volumes[i]
        if count:
            positions = rows.scene.arms[i].positions
            log_volume, slope = one.log_volume(x[own], positions)
            by_volume[own] = -count * slope
            volume -= count * (log_volume - objective.nominal_log_volumes[i])
    return Linearization(points, errors, by_x, by_joints, volume, by_volume)


def predict_balls(objective: Objective, x: np.ndarray) -> Balls:
    """Return all balls, with the derivatives of what was measured of them."""
    model, scene = objective.model, objective.rows.scene
    parts = [
        _balls_of(one, x[own], arm)
        for own, one, arm in zip(model.own, model.models, scene.arms, strict=True)
    ]
    if len(parts) == 1:
        return parts[0]
    widest = max(by_joints.shape[2] for _, _, by_joints, _ in parts)
    size = model.own[-1].stop
    by_x = [
        np.pad(J, ((0, 0), (0, 0), (own.start, size - own.stop)))
        for own, (_, J, _, _) in zip(model.own, parts, strict=True)
    ]
    by_joints = [np.pad(Jq, ((0, 0), (0, 0), (0, widest - Jq.shape[2]))) for _, _, Jq, _ in parts]
    points, rotations = (np.concatenate([part[i] for part in parts]) for i in (0, 3))
    return points, np.concatenate(by_x), np.concatenate(by_joints), rotations


def _balls_of(model: ExtendedModel, x: np.ndarray, data: Observations) -> Balls:
    """Return the balls of one robot."""
    q, torques, turned = data.positions, data.torques, data.turned
    points, by_x, by_joints = model.linearise(x, q, torques)
    rotations = np.broadcast_to(np.eye(3), (len(q), 3, 3))
    if turned.any():
        rotations = rotations.copy()
        rotations[turned], by_x[turned], by_joints[turned] = model.linearise(
            x, q[turned], torques[turned], of_turns=True
        )
    return points, by_x, by_joints, rotations


def to_world(objective: Objective, frames: tuple[Pose, ...], points: np.ndarray) -> np.ndarray:
    """Return balls in the world instead of each in its own robot's base, shape (N, 3) [m]."""
    bases = [objective.rows.base(i, frames) for i in range(len(objective.model.models))]
    parts = [
        points[rows] if base is None else base.apply(points[rows])
        for rows, base in zip(objective.rows.own, bases, strict=True)
    ]
    return np.concatenate(parts) if len(parts) > 1 else parts[0]


def _errors(
    objective: Objective, balls: Balls, centres: np.ndarray, frames: tuple[Pose, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the errors e_i, and their derivatives by x and the frames, and by the joints."""
    rows, (points, by_x, by_joints, rotations) = objective.rows, balls
    errors = np.array(to_world(objective, frames, points))
    errors[rows.seated] -= centres[rows.sockets[rows.seated]]
    if not frames:
        return errors, by_x, by_joints
    by_frames = np.zeros((len(points), 3, 6 * len(frames)))
    by_x, by_joints = by_x.copy(), by_joints.copy()
    for i, own in enumerate(rows.own):
        base = rows.base(i, frames)
        if base is not None:
            by_x[own], by_joints[own] = base.rotation @ by_x[own], base.rotation @ by_joints[own]
            k = rows.scene.bases[i]
            by_frames[own, :, 6 * k : 6 * k + 6] = base.slopes(points[own])
            rotations = rotations.copy()
            rotations[own] = base.rotation @ rotations[own]
            there = own.start + np.flatnonzero(rows.turned_in[own] >= 0)
            by_frames[there, :, 6 * k : 6 * k + 6] = np.eye(3, 6)
    for k, frame in enumerate(frames):
        measured = np.flatnonzero(rows.measured_in == k)
        errors[measured] -= frame.apply(rows.points[measured])
        by_frames[measured, :, 6 * k : 6 * k + 6] = -frame.slopes(rows.points[measured])
        turned = np.flatnonzero(rows.turned_in == k)
        placed = frame.rotation @ rows.rotations[turned]
        errors[turned] = rotation_vectors(rotations[turned] @ placed.swapaxes(1, 2))
        by_frames[turned, :, 6 * k : 6 * k + 6] = -np.eye(3, 6)
    return errors, np.concatenate([by_x, by_frames], axis=2), by_joints


def constraint_residuals(objective: Objective, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return what is known of the sockets, as rows of the least-squares problem."""
    known, located = objective.rows.scene.arms[0].known, objective.rows.located
    rows = np.zeros((len(known), objective.size))
    values = np.zeros(len(known))
    for i, k in enumerate(known):
        offset = state.centres[k.second] - state.centres[k.first]
        length = float(np.linalg.norm(offset))
        for socket, sign in ((k.second, 1), (k.first, -1)):
            begin = objective.dense + 3 * socket
            rows[i, begin : begin + 3] = sign * offset / length
        values[i] = length - k.distance
    whitened = [(objective.whiten @ rows, objective.whiten @ values)]
    for one in located:
        row, place = np.zeros((3, objective.size)), np.array([one.coordinates])
        begin = objective.dense + 3 * one.socket
        row[:, begin : begin + 3] = np.eye(3)
        if one.frame != WORLD:
            begin = objective.model.size + 6 * one.frame
            row[:, begin : begin + 6] = -state.frames[one.frame].slopes(place)[0]
            place = state.frames[one.frame].apply(place)
        off = state.centres[one.socket] - place[0]
        whitened.append((row / one.deviation, off / one.deviation))
    return np.concatenate([a for a, _ in whitened]), np.concatenate([b for _, b in whitened])


def priors(state: State) -> list[tuple[PriorGroup, np.ndarray]]:
    """Return the groups that have a width, and which members of each are not held."""
    kept = [(g, ~state.at_zero[g.members]) for g in state.groups if g.width]
    return [(group, free) for group, free in kept if free.any()]


def free_unknowns(objective: Objective, state: State) -> np.ndarray:
    """Return which of all unknowns are not held at zero, shape (n,)."""
    free = np.ones(objective.size, dtype=bool)
    free[: objective.model.size] = False
    for group, kept in priors(state):
        free[group.members[kept]] = True
    return free


def prior_precision(objective: Objective, state: State, *, widened: bool = False) -> np.ndarray:
    """Return P of x and the frames, shape (dense, dense)."""
    P = np.zeros((objective.dense, objective.dense))
    for group, free in priors(state):
        width, members = group.deviation if widened else group.width, group.members[free]
        P[members[:, None], members] = group.precision(width, free)
    frames = np.arange(objective.model.size, objective.dense)
    P[frames, frames] = np.tile(FRAME_PRIOR_PRECISION**2, objective.rows.frame_count)
    return P


def prior_gradient(objective: Objective, state: State, precision: np.ndarray) -> np.ndarray:
    """Return the slope of the priors' part of L, P (x - mu), shape (n,)."""
    apart = np.zeros(objective.dense)
    apart[: len(state.x)] = state.x
    for group in state.groups:
        if group.width:
            apart[group.members] -= group.mean
    slope = np.zeros(objective.size)
    slope[: objective.dense] = precision @ apart
    return slope
