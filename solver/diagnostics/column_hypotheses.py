"""What the columns of a recording may be instead of the model's joints, and how that is said."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..robot import Robot
from .robust_fit import Samples

_ADVICE = {
    "sign": "change the sign in the recording, or of the axis in the model",
    "swap": "bring the columns into the order of the model's chain",
    "zero": "set the joint's zero, or choose the model of this robot's version",
}


@dataclass(frozen=True)
class ColumnHypothesis:
    """What the columns may be instead: q[order] * signs - zeros."""

    robot: Robot
    order: np.ndarray
    signs: np.ndarray
    zeros: np.ndarray

    def of(self, samples: Samples) -> Samples:
        """Return samples as they would be."""
        q = samples.positions[:, self.order] * self.signs - self.zeros
        return Samples(q, samples.sockets)

    @property
    def mistakes(self) -> dict[str, list[int]]:
        """Which joints it blames, by ``sign``, ``swap`` and ``zero``; no kind without any."""
        joints = {
            "sign": np.flatnonzero(self.signs < 0),
            "swap": np.flatnonzero(self.order != np.arange(len(self.order))),
            "zero": np.flatnonzero(self.zeros),
        }
        return {kind: found.tolist() for kind, found in joints.items() if len(found)}

    @property
    def code(self) -> str:
        """The first kind of mistake, ``sign`` before ``swap`` before ``zero``."""
        return next(iter(self.mistakes))

    @property
    def text(self) -> str:
        """What is wrong, and what mends it."""
        mends = {"sign": "-q", "swap": "their columns exchanged", "zero": "that taken off"}
        words = " and ".join(self._words(*one) for one in self.mistakes.items())
        return f"{words}: with {' and '.join(mends[kind] for kind in self.mistakes)}"

    @property
    def advice(self) -> str:
        """What to do."""
        return "; ".join(_ADVICE[kind] for kind in self.mistakes)

    def _words(self, kind: str, joints: Sequence[int]) -> str:
        how = {"sign": "sign-flipped", "swap": "swapped"}.get(kind)
        off = " and ".join(f"{np.rad2deg(self.zeros[j]):+.1f}" for j in joints)
        return f"{_names(self.robot, joints)} {how or f'off by {off} deg'}"


def unchanged(robot: Robot) -> ColumnHypothesis:
    """Return the guess that nothing is wrong."""
    m = len(robot.actuated)
    return ColumnHypothesis(robot, np.arange(m), np.ones(m), np.zeros(m))


def signs(robot: Robot, count: int) -> Iterator[ColumnHypothesis]:
    """Return the guesses that so many joints have the other sign."""
    right = unchanged(robot)
    for joints in combinations(range(len(robot.actuated)), count):
        flipped = right.signs.copy()
        flipped[list(joints)] = -1
        yield replace(right, signs=flipped)


def swaps(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Return the guesses that two columns are exchanged."""
    right = unchanged(robot)
    for i, j in combinations(range(len(robot.actuated)), 2):
        order = right.order.copy()
        order[[i, j]] = j, i
        yield replace(right, order=order)


def with_zero(guess: ColumnHypothesis, joint: int, zero: float) -> ColumnHypothesis:
    """Return a guess by which a joint's zero is off by so much, too."""
    zeros = guess.zeros.copy()
    zeros[joint] = zero
    return replace(guess, zeros=zeros)


def _names(robot: Robot, joints: Sequence[int]) -> str:
    numbers = " and ".join(str(joint + 1) for joint in joints)
    names = ", ".join(robot.joint_names[joint] for joint in joints)
    many = len(joints) > 1
    return f"joint{'s' * many} {numbers} ({names}) look{'s' * (not many)}"
