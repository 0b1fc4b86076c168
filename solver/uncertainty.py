"""How well a calibration is known: deviations, what the data cannot identify, predicted errors."""
# NumPy's linear algebra is partly untyped.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .deflection import coefficient_names
from .evidence import INFORMATION, Estimate
from .observations import Load
from .urdf import Chain

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
    "workspace",
]

Vector = NDArray[np.float64]
CANNOT_SEE = (
    "the base frame: the sockets' places in it are not measured, only their distances",
    "the flange's orientation and the last joint's offset: another tool needs its own TCP "
    "calibration",
)
"""What no recording of a ball can tell."""
UNDECIDED = 0.5
"""A direction whose posterior deviation is more than this part of its prior's is the prior's."""
STRONG = 0.9


def unknown_names(found: Estimate) -> list[str]:
    """Return the names of all unknowns before the socket centres."""
    problem = found.problem
    names = [p.name for p in problem.parameters]
    for extension in problem.extensions:
        names += coefficient_names(extension, problem.chain.joint_names)
    return names


def deviations(found: Estimate) -> Vector:
    """Return the posterior standard deviation of every unknown before the centres."""
    return np.sqrt(np.diag(found.covariance)[: found.problem.size])


def prior_deviations(found: Estimate) -> Vector:
    """Return the prior standard deviation of every unknown before the centres."""
    widths = np.zeros(found.problem.size)
    for group in found.groups:
        widths[group.members] = group.width
    return widths


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
    widths = prior_deviations(found)[:n]
    scaled = found.covariance[:n, :n] / np.outer(widths, widths)
    named = _structural(problem.chain, found)
    basis = (
        np.linalg.qr(np.array([v / widths for _, v in named]).T)[0] if named else np.zeros((n, 0))
    )
    found_directions = [
        Direction(text, float(np.sqrt(u @ scaled @ u)))
        for text, v in named
        for u in [v / widths / np.linalg.norm(v / widths)]
    ]
    rest = np.eye(n) - basis @ basis.T
    values, vectors = np.linalg.eigh(rest @ scaled @ rest)
    names = unknown_names(found)
    for value, vector in zip(values[::-1], vectors.T[::-1], strict=True):
        if value < UNDECIDED**2:
            break
        main = np.argsort(-np.abs(vector))[:2]
        text = " against ".join(names[i] for i in main)
        found_directions.append(Direction(f"mainly {text}", float(np.sqrt(value))))
    merged: dict[str, Direction] = {}
    for direction in found_directions:
        if direction.deviation > UNDECIDED:
            merged.setdefault(direction.text, direction)
    return list(merged.values())


def _structural(chain: Chain, found: Estimate) -> list[tuple[str, Vector]]:
    """Return changes of the free geometry that leave every ball where it is, with their names."""
    from .kinematics import rotation, rotation_rpy

    problem = found.problem
    place = {p.index: i for i, p in enumerate(problem.parameters)}
    free = [j for j in range(len(chain.joints)) if all(6 * j + k in place for k in range(6))]
    origins = problem.model.origins(found.values)
    named: list[tuple[str, Vector]] = []

    def vector(entries: dict[int, float]) -> Vector:
        v = np.zeros(problem.geometry)
        for index, value in entries.items():
            v[place[index]] = value
        return v

    if free and chain.joints[free[0]].actuated:
        named += [("the base frame", vector({6 * free[0] + k: 1.0})) for k in range(6)]
    ball = len(chain.joints) - 1
    if ball in free:
        named += [("the ball's orientation", vector({6 * ball + k: 1.0})) for k in (3, 4, 5)]
    for one, other in pairwise(free):
        joint = chain.joints[one]
        if not joint.actuated or other != one + 1:
            continue
        following = chain.joints[other]
        axis = np.array(joint.axis)
        R = np.array(rotation_rpy(origins[one, 3:]).full())
        slide = {6 * one + k: float((R @ axis)[k]) for k in range(3)}
        slide |= {6 * other + k: float(-axis[k]) for k in range(3)}
        named.append((f"sliding along {joint.name}'s axis", vector(slide)))
        if joint.type == "prismatic":
            continue
        h = 1e-6
        turned = np.array(rotation(joint.axis, h).full())
        turn = {6 * one + 3 + k: v for k, v in enumerate(_rpy(R @ turned, origins[one, 3:], h))}
        back = np.array(rotation(joint.axis, -h).full())
        moved = (back @ origins[other, :3] - origins[other, :3]) / h
        turn |= {6 * other + k: float(moved[k]) for k in range(3)}
        R_next = np.array(rotation_rpy(origins[other, 3:]).full())
        turn |= {
            6 * other + 3 + k: v for k, v in enumerate(_rpy(back @ R_next, origins[other, 3:], h))
        }
        against = "the ball" if following is chain.ball_joint else following.name
        named.append((f"{joint.name}'s offset against {against}", vector(turn)))
    return named


def _rpy(R: Vector, near: Vector, h: float) -> list[float]:
    """Return the rate of roll, pitch, yaw that leads from angles to a rotation h away."""
    from .kinematics import rotation_rpy

    R_near = np.array(rotation_rpy(near).full())
    rates = []
    for k in range(3):
        step = np.zeros(3)
        step[k] = 1e-6
        dR = (np.array(rotation_rpy(near + step).full()) - R_near) / 1e-6
        rates.append(dR.ravel())
    solution = np.linalg.lstsq(np.array(rates).T, ((R - R_near) / h).ravel(), rcond=None)[0]
    return solution.tolist()


def workspace(chain: Chain, count: int, seed: int = 0) -> Vector:
    """Return random joint positions within the limits, and within one turn, shape (count, m)."""
    lower = np.array([max(j.lower, -np.pi) for j in chain.actuated])
    upper = np.array([min(j.upper, np.pi) for j in chain.actuated])
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


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
    from .kinematics import gravity_torques

    chain = found.problem.chain
    q = workspace(chain, 2 * pairs)
    torque = gravity_torques(chain, q, load.gravity, load.payload)
    deviation = distance_deviations(found, q, torque)
    return {"median": float(np.median(deviation)), "worst": float(deviation.max())}
