"""Changes of the free geometry that no ball can show, by the chain of joints alone."""

from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..identification.data import IDENTITY, Pose
from ..identification.inference import Posterior

BASE = "the base frame"
BALL = "the ball's orientation"


class Change(NamedTuple):
    """A change of the free geometry."""

    text: str
    """Its name for people."""
    vector: np.ndarray
    """Shape (geometry,), in some unit."""


def structural_changes(posterior: Posterior) -> Iterator[Change]:
    """Yield changes of the free geometry that no ball can show."""
    chain = FreeChain(posterior)
    joints = chain.joints
    if joints and chain.links[joints[0]].actuated:
        for number in np.eye(6):
            yield chain.change(BASE, {joints[0]: number})
    if chain.ball in joints:
        for number in np.eye(6)[3:]:
            yield chain.change(BALL, {chain.ball: number})
    for first, second in pairwise(joints):
        links = chain.links[first:second]
        is_actuated = [link.actuated for link in links]
        if is_actuated[0] and sum(is_actuated) == 1:
            yield from chain.along_axis(first, second)


class FreeChain:
    """A chain of joints at a posterior's mean, and changes of their origins that are free."""

    def __init__(self, posterior: Posterior) -> None:
        model = posterior.model
        self.size = model.geometry
        self.links = model.robot.joints
        self.ball = len(self.links) - 1
        self.frames = model.ball.frames(posterior.values)
        self._places: dict[int, list[int]] = {}
        place = {p.index: i for i, p in enumerate(model.parameters)}
        for joint in range(len(self.links)):
            numbers = range(6 * joint, 6 * joint + 6)
            if place.keys() >= {*numbers}:
                self._places[joint] = [place[number] for number in numbers]

    @property
    def joints(self) -> list[int]:
        """The joints with an origin all six numbers of which are free."""
        return list(self._places)

    def change(
        self,
        text: str,
        by_joint: Mapping[int, np.ndarray],
    ) -> Change:
        """Return a change of some joints' origins, each by six numbers."""
        vector = np.zeros(self.size)
        for joint, numbers in by_joint.items():
            vector[self._places[joint]] = numbers
        return Change(text, vector)

    def along_axis(
        self,
        first: int,
        second: int,
    ) -> Iterator[Change]:
        """Yield what the axis of a joint allows to pass on to the next free origin.

        The first joint's origin slides along its axis, or turns about it, and the second one's
        origin moves back, so that all beyond stays.
        """
        joint = self.links[first]
        frame = self.frames[first]
        next_frame = self.frames[second]
        fixed = [Pose(f[:, 1:4], f[:, 0]) for f in self.frames[first + 1 : second]]
        to_second = reduce(Pose.__matmul__, fixed, IDENTITY).inverse()
        axis = np.array(joint.axis)
        outward = frame[:, 1:4] @ axis
        back = -to_second.rotation @ axis
        still = np.zeros(3)
        slides = {
            first: np.append(outward, still),
            second: np.append(back, still),
        }
        yield self.change(f"sliding along {joint.name}'s axis", slides)
        if joint.type == "prismatic":
            return
        lever = next_frame[:, 0] - to_second.translation
        shift = np.cross(back, lever)
        turns = {
            first: np.append(still, _rates(frame, outward)),
            second: np.append(shift, _rates(next_frame, back)),
        }
        next_name = self.links[second].name
        if second == self.ball:
            next_name = "the ball"
        yield self.change(f"{joint.name}'s offset against {next_name}", turns)


def _rates(
    frame: np.ndarray,
    spin: np.ndarray,
) -> np.ndarray:
    """Return how fast the numbers of a rotation change while its frame spins about a vector."""
    # The spin is the sum of the rates times the axes.
    axes = frame[:, 4:]
    rates, *_ = np.linalg.lstsq(axes, spin, rcond=None)
    return rates
