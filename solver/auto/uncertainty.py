"""How well a calibration is known: deviations, what the data cannot identify, predicted errors."""
# NumPy's linear algebra is partly untyped.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..data.observations import Load
from ..robot.kinematics import gravity_torques, rotation, rotation_rpy, workspace
from ..robot.urdf import Joint, Robot
from .deflection import coefficient_names
from .posterior import INFORMATION, Estimate

__all__ = [
    "CANNOT_SEE",
    "Direction",
    "correlations",
    "deviations",
    "distance_deviations",
    "observability_index",
    "predicted_deviation",
    "unknown_names",
    "weak_directions",
]

Vector = NDArray[np.float64]
CANNOT_SEE = (
    "the base frame: the sockets' places in it are not measured, only their distances",
    "the flange's orientation and the last joint's offset: another tool needs its own TCP "
    "calibration",
)
"""What no recording of a ball can tell."""
SCALE = "the scale of all lengths (a longer base, or known distances, would tell it)"
UNDECIDED = 0.5
"""A direction whose posterior deviation is more than this part of its prior's is the prior's."""
STRONG = 0.9


def unknown_names(found: Estimate) -> list[str]:
    """Return the names of all unknowns before the socket centres."""
    problem = found.problem
    names = [p.name for p in problem.parameters]
    for extension in problem.extensions:
        names += coefficient_names(extension, problem.robot.joint_names)
    return names


def deviations(found: Estimate) -> Vector:
    """Return the posterior standard deviation of every unknown before the centres."""
    return np.sqrt(np.diag(found.covariance)[: found.problem.size])


def prior_covariance(found: Estimate) -> Vector:
    """Return the prior covariance of all unknowns before the centres."""
    covariance = np.zeros((found.problem.size,) * 2)
    for group in found.groups:
        covariance[np.ix_(group.members, group.members)] = group.covariance(group.deviation)
    return covariance


def prior_deviations(found: Estimate) -> Vector:
    """Return the prior standard deviation of every unknown before the centres."""
    return np.sqrt(np.diag(prior_covariance(found)))


def correlations(found: Estimate) -> list[tuple[str, str, float]]:
    """Return pairs of unknowns that the data decide only together: correlation beyond 0.9."""
    size = found.problem.size
    deviation = deviations(found)
    known = np.flatnonzero((deviation > 0) & (deviation < UNDECIDED * prior_deviations(found)))
    covariance = found.covariance[:size, :size][np.ix_(known, known)]
    matrix = covariance / np.outer(deviation[known], deviation[known])
    names = unknown_names(found)
    rows, columns = np.nonzero(np.triu(np.abs(matrix) > STRONG, k=1))
    pairs = [
        (names[known[i]], names[known[j]], float(matrix[i, j]))
        for i, j in zip(rows.tolist(), columns.tolist(), strict=True)
    ]
    return sorted(pairs, key=lambda pair: -abs(pair[2]))


def observability_index(found: Estimate) -> float:
    """Return O1 of Borm and Menq (1991): (s_1 ... s_L)^(1/L) / sqrt(N).

    The s are the singular values of the ball positions' derivatives by the geometry, each number
    in units of its prior's width, as far as the configurations excite it (s > 1e-6 s_1).
    """
    problem = found.problem
    data = problem.data
    _, jacobian, _ = problem.linearise(found.x, data.positions, data.torques)
    scaled = jacobian[:, :, : problem.geometry] * prior_deviations(found)[: problem.geometry]
    centred = np.concatenate(
        [rows - rows.mean(axis=0) for k in range(data.socket_count)
         for rows in [scaled[data.sockets == k]]]
    )  # fmt: skip
    values = np.linalg.svd(centred.reshape(-1, problem.geometry), compute_uv=False)
    values = values[values > 1e-6 * values[0]]
    return float(np.exp(np.mean(np.log(values))) / np.sqrt(len(data.positions)))


@dataclass(frozen=True)
class Direction:
    """Something that the data cannot tell, in words."""

    text: str
    deviation: float
    """Posterior over prior deviation along it, 1 where the data say nothing."""


def weak_directions(found: Estimate) -> list[Direction]:
    """Return what the data leave to the prior, in words.

    First the directions that no ball can show, by the chain's structure; then the largest of
    what remains, by its two main parameters.
    """
    problem = found.problem
    n = problem.geometry
    prior = np.linalg.cholesky(prior_covariance(found)[:n, :n])  # x = prior @ standard normal
    whiten = np.linalg.inv(prior)
    posterior = whiten @ found.covariance[:n, :n] @ whiten.T
    named = [
        (text, whiten @ v / np.linalg.norm(whiten @ v))
        for text, v in _structural(problem.robot, found)
    ]
    by_scale = prior.T @ problem.by_scale()[:n]
    if by_scale.any():
        named.append((SCALE, by_scale / np.linalg.norm(by_scale)))
    found_directions = [Direction(text, float(np.sqrt(u @ posterior @ u))) for text, u in named]
    basis = np.linalg.qr(np.array([u for _, u in named]).T)[0] if named else np.zeros((n, 0))
    rest = np.eye(n) - basis @ basis.T
    values, vectors = np.linalg.eigh(rest @ posterior @ rest)
    names = unknown_names(found)
    for value, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        if value < UNDECIDED**2:
            break
        main = np.argsort(-np.abs(prior @ vector) / np.linalg.norm(prior, axis=1))[:2]
        text = " against ".join(names[i] for i in main)
        found_directions.append(Direction(f"mainly {text}", float(np.sqrt(value))))
    merged: dict[str, Direction] = {}
    for direction in found_directions:
        if direction.deviation > UNDECIDED:
            merged.setdefault(direction.text, direction)
    return list(merged.values())


def _structural(robot: Robot, found: Estimate) -> list[tuple[str, Vector]]:
    """Return changes of the free geometry that no ball can show, with their names.

    The base frame may move as a whole; the ball may turn in place; and each joint may slide along
    its axis or turn about it, if the next free joint undoes that.
    """
    problem = found.problem
    place = {p.index: i for i, p in enumerate(problem.parameters)}
    free = [j for j in range(len(robot.joints)) if all(6 * j + k in place for k in range(6))]
    origins = problem.model.origins(found.values)
    named: list[tuple[str, Vector]] = []

    def add(text: str, changes: dict[int, Vector]) -> None:
        vector = np.zeros(problem.geometry)
        for joint, change in changes.items():
            vector[[place[6 * joint + k] for k in range(6)]] = change
        named.append((text, vector))

    if free and robot.joints[free[0]].actuated:
        for k in range(6):
            add("the base frame", {free[0]: np.eye(6)[k]})
    ball = len(robot.joints) - 1
    if ball in free:
        for k in (3, 4, 5):
            add("the ball's orientation", {ball: np.eye(6)[k]})
    for one, other in pairwise(free):
        joint = robot.joints[one]
        if not joint.actuated or any(j.actuated for j in robot.joints[one + 1 : other]):
            continue
        against = "the ball" if other == ball else robot.joints[other].name
        R, p = _between(robot.joints, origins, one, other)
        own, axis = _frame(origins[one])[0], np.array(joint.axis)
        slide, back = np.zeros(6), np.zeros(6)
        slide[:3], back[:3] = own @ axis, -R.T @ axis
        add(f"sliding along {joint.name}'s axis", {one: slide, other: back})
        if joint.type == "prismatic":
            continue
        turn = np.concatenate([np.zeros(3), _rates(origins[one], own @ axis)])
        lever = origins[other, :3] + R.T @ p
        back = np.concatenate([-np.cross(R.T @ axis, lever), _rates(origins[other], -R.T @ axis)])
        add(f"{joint.name}'s offset against {against}", {one: turn, other: back})
    return named


def _frame(origin: Vector) -> tuple[Vector, Vector]:
    """Return rotation and translation of an origin."""
    return np.array(rotation_rpy(origin[3:]).full()), origin[:3]


def _between(
    joints: Sequence[Joint], origins: Vector, one: int, other: int
) -> tuple[Vector, Vector]:
    """Return rotation and translation from one joint's child link to another's parent link."""
    transform = np.eye(4)
    for j in range(one + 1, other):
        assert not joints[j].actuated
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = _frame(origins[j])
        transform = transform @ step
    return transform[:3, :3], transform[:3, 3]


def _rates(origin: Vector, spin: Vector) -> Vector:
    """Return the rates of roll, pitch and yaw of a rotation that spins about a parent's vector.

    With R = Rz(yaw) Ry(pitch) Rx(roll), the spin is the sum of the rates times the axes as they
    stand: x after pitch and yaw, y after yaw, and z.
    """
    _, pitch, yaw = origin[3:]
    Rz = np.array(rotation((0, 0, 1), yaw).full())
    Ry = np.array(rotation((0, 1, 0), pitch).full())
    axes = np.stack([Rz @ Ry @ [1, 0, 0], Rz @ [0, 1, 0], np.array([0, 0, 1])], axis=1)
    rates: Vector = np.linalg.lstsq(axes, spin, rcond=None)[0].astype(np.float64)
    return rates


def distance_deviations(found: Estimate, q: Vector, torque: Vector) -> Vector:
    """Return the predicted 1-sigma error of the distances between successive ball positions.

    Args:
        found: The calibration.
        q: Joint positions, shape (2 N, m); rows 0 and 1, 2 and 3, ... are pairs.
        torque: Their joint torques.

    Returns:
        Shape (N,) [m].
    """
    points, jacobian, _ = found.problem.linearise(found.x, q, torque)
    offset = points[1::2] - points[::2]
    direction = offset / np.linalg.norm(offset, axis=1, keepdims=True).clip(1e-12)
    slopes = np.einsum("ni,nij->nj", direction, jacobian[1::2] - jacobian[::2])
    size = found.problem.size
    return np.sqrt(np.einsum("ni,ij,nj->n", slopes, found.covariance[:size, :size], slopes))


def predicted_deviation(found: Estimate, by_socket: Sequence[tuple[Vector, Vector]]) -> float:
    """Return the predicted rms distance of samples from their socket's mean, noise included [m].

    Args:
        found: The calibration.
        by_socket: Joint positions and torques of the samples in each socket.
    """
    size = found.problem.size
    covariance = found.covariance[:size, :size]
    total, count = 0.0, 0
    for q, torque in by_socket:
        _, jacobian, by_joints = found.problem.linearise(found.x, q, torque)
        centred = jacobian - jacobian.mean(axis=0)
        total += float(np.einsum("nij,jk,nik->", centred, covariance, centred))
        noise = np.trace(found.noise.scales(by_joints), axis1=1, axis2=2).sum() / INFORMATION
        total += float(noise) * (1 - 1 / len(q))
        count += len(q)
    return (total / count) ** 0.5


def workspace_deviation(found: Estimate, load: Load, pairs: int = 200) -> dict[str, float]:
    """Return median and worst predicted error of distances between random poses [m]."""
    robot = found.problem.robot
    q = workspace(robot, 2 * pairs)
    torque = gravity_torques(robot, q, load.gravity, load.payload)
    deviation = distance_deviations(found, q, torque)
    return {"median": float(np.median(deviation)), "worst": float(deviation.max())}
