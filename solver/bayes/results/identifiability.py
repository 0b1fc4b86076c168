"""Directions of the geometry that the data do not identify, in words."""

from collections.abc import Sequence
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...data import IDENTITY, Pose
from ...results import Direction
from ..inference import Posterior
from .projections import basis_of, outside
from .uncertainty import UNDECIDED

UNOBSERVABLE = (
    "the base frame: you measured distances between sockets, not their positions in the base frame",
    "the flange's orientation and the last joint's offset: another tool needs its own TCP "
    "calibration",
)
"""Unknowns that no recording of a ball in sockets can tell."""
BASE_TURNS = (
    "the base frame: it can still turn about the sockets that you measured. Measure three or more "
    "that are not on one line"
)
BASE_OF_POINTS = "the base frame: nobody measured where the instrument stands in it"
BASE = "the base frame"
SCALE = "the scale of all lengths (a longer base, or known distances, would tell it)"


class Change(NamedTuple):
    """A change of the free geometry."""

    text: str
    """Its name for people."""
    vector: np.ndarray
    """Shape (geometry,), in some unit."""


def weak_directions(posterior: Posterior) -> tuple[Direction, ...]:
    """Return what the data cannot tell, in words.

    First come directions that no ball can show in any chain of joints like this one; then those
    that these recordings do not show, named by the two parameters that take part most. With L L^T
    the prior covariance of the geometry, z = L^-1 x has the prior N(0, 1) and the posterior
    covariance L^-1 Sigma L^-T. Its deviation along a direction is 1 where the data tell nothing.
    """
    n = posterior.model.geometry
    L = np.linalg.cholesky(posterior.prior_covariance[:n, :n])
    whiten = np.linalg.inv(L)
    covariance = whiten @ posterior.covariance[:n, :n] @ whiten.T
    structural = _structural(posterior)
    changes = [Change(text, _unit(whiten @ vector)) for text, vector in structural]
    if posterior.data.anchored:
        changes = _without_turns_of_joints(changes, n)
    by_scale = L.T @ posterior.model.by_scale()[:n]
    if by_scale.any():
        changes.append(Change(SCALE, _unit(by_scale)))
    Q = _basis(changes, n)
    remaining = outside(outside(covariance, Q).T, Q)
    values, vectors = np.linalg.eigh(remaining)
    undecided = np.flatnonzero(values > UNDECIDED**2)
    for vector in vectors.T[undecided[::-1]]:
        shares = np.abs(L @ vector) / np.linalg.norm(L, axis=1)
        largest: list[int] = np.argsort(-shares)[:2].tolist()
        names = [posterior.model.names[i] for i in largest]
        changes.append(Change(f"mainly {' against '.join(names)}", vector))
    directions: dict[str, Direction] = {}
    for text, u in changes:
        deviation = float(u @ covariance @ u) ** 0.5
        if deviation > UNDECIDED:
            directions.setdefault(text, Direction(text, deviation))
    return tuple(directions.values())


def _without_turns_of_joints(changes: Sequence[Change], n: int) -> list[Change]:
    """Return changes, those of a base whose place is known without what other changes are as well.

    A turn of the base about joint 1 is one thing with joint 1's offset, which no ball shows.
    """
    Q = _basis([change for change in changes if change.text != BASE], n)
    return [
        Change(text, _unit(outside(u, Q)) if text == BASE else u) for text, u in changes
    ]


def _basis(changes: Sequence[Change], n: int) -> np.ndarray:
    """Return an orthonormal basis of changes, shape (n, changes)."""
    vectors = [change.vector for change in changes]
    return basis_of(np.reshape(vectors, (-1, n)).T)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def unobservable(posterior: Posterior, weak: Sequence[Direction]) -> tuple[str, ...]:
    """Return what no recording of this kind can determine, in words."""
    base, flange = UNOBSERVABLE
    if not posterior.data.anchored:
        return (base if posterior.data.labels else BASE_OF_POINTS, flange)
    turns = any(direction.text == BASE for direction in weak)
    return (BASE_TURNS, flange) if turns else (flange,)


def _structural(posterior: Posterior) -> list[Change]:
    """Return changes of the free geometry that no ball can show."""
    model = posterior.model
    chain = model.robot.joints
    place = {p.index: i for i, p in enumerate(model.parameters)}
    numbers = [range(6 * j, 6 * j + 6) for j in range(len(chain))]
    joints = [j for j, of_joint in enumerate(numbers) if place.keys() >= {*of_joint}]
    ball = len(chain) - 1
    frames = model.ball.frames(posterior.values)
    result: list[Change] = []

    def add(text: str, changes: dict[int, np.ndarray]) -> None:
        vector = np.zeros(model.geometry)
        for joint, change in changes.items():
            vector[[place[number] for number in numbers[joint]]] = change
        result.append(Change(text, vector))

    if joints and chain[joints[0]].actuated:
        for unit in np.eye(6):
            add(BASE, {joints[0]: unit})
    if ball in joints:
        for unit in np.eye(6)[3:]:
            add("the ball's orientation", {ball: unit})
    for j, other in pairwise(joints):
        joint = chain[j]
        between = chain[j + 1 : other]
        if not joint.actuated or any(link.actuated for link in between):
            continue
        fixed = [Pose(frame[:, 1:4], frame[:, 0]) for frame in frames[j + 1 : other]]
        to_other = reduce(Pose.__matmul__, fixed, IDENTITY).inverse()
        axis = np.array(joint.axis)
        outward = frames[j, :, 1:4] @ axis
        back = -to_other.rotation @ axis
        still = np.zeros(3)
        slides = {j: np.append(outward, still), other: np.append(back, still)}
        add(f"sliding along {joint.name}'s axis", slides)
        if joint.type == "prismatic":
            continue
        lever = frames[other, :, 0] - to_other.translation
        shift = np.cross(back, lever)
        turns = {
            j: np.append(still, _rates(frames[j], outward)),
            other: np.append(shift, _rates(frames[other], back)),
        }
        against = "the ball" if other == ball else chain[other].name
        add(f"{joint.name}'s offset against {against}", turns)
    return result


def _rates(frame: np.ndarray, spin: np.ndarray) -> np.ndarray:
    """Return how fast the numbers of a rotation change while its frame spins about a vector."""
    # The spin is the sum of the rates times the axes.
    return np.linalg.lstsq(frame[:, 4:], spin, rcond=None)[0]
