"""Hypotheses on columns of joint positions: signs, orders and offsets."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ...errors import fixed
from ..identification.robot import Robot
from .hypotheses import SeatSamples

STATES = {
    "sign": "sign-flipped",
    "swap": "swapped",
    "zero": "off",
}
"""How joints look, by the kind of the mistake."""


@dataclass(frozen=True)
class ColumnHypothesis:
    """Hypothesis that the true joint positions are q[order] * signs - offsets."""

    robot: Robot
    order: np.ndarray
    signs: np.ndarray
    offsets: np.ndarray

    def apply(self, samples: SeatSamples) -> SeatSamples:
        """Return samples as they would be."""
        q = samples.q[:, self.order] * self.signs - self.offsets
        return replace(samples, q=q)

    @property
    def mistakes(self) -> dict[str, list[int]]:
        """Joints that it blames, by ``sign``, ``swap`` and ``zero``; no kind without any."""
        in_order = np.arange(len(self.order))
        joints = {
            "sign": np.flatnonzero(self.signs < 0).tolist(),
            "swap": np.flatnonzero(self.order != in_order).tolist(),
            "zero": np.flatnonzero(self.offsets).tolist(),
        }
        return {kind: indices for kind, indices in joints.items() if indices}

    @property
    def name(self) -> str:
        """Name of the explanation: an ``order`` is a swap of more than two."""
        mistakes = self.mistakes
        first = next(iter(mistakes))  # sign before swap before zero
        if first == "swap" and len(mistakes[first]) > 2:
            return "order"
        return first

    @property
    def text(self) -> str:
        """The mistakes, and what mends them."""
        mistakes = self.mistakes
        joints = mistakes.get("zero", ())
        degrees = [fixed(np.rad2deg(-self.offsets[joint]), 1, "+") for joint in joints]
        readings = "it reads" if len(joints) == 1 else "they read"
        mends = {
            "sign": "-q",
            "swap": "their columns put right",
            "zero": f"{' and '.join(degrees)} deg added to what {readings}",
        }
        blames = [self._blame(kind, indices) for kind, indices in mistakes.items()]
        mending = [mends[kind] for kind in mistakes]
        return f"{' and '.join(blames)}: with {' and '.join(mending)}"

    def _blame(self, kind: str, joints: Sequence[int]) -> str:
        if kind == "swap" and len(joints) > 2:
            order = ", ".join(map(str, self.order + 1))
            return f"the columns look out of order: {order}"
        numbers = " and ".join(str(joint + 1) for joint in joints)
        names = ", ".join(self.robot.joint_names[joint] for joint in joints)
        if len(joints) == 1:
            return f"joint {numbers} ({names}) looks {STATES[kind]}"
        return f"joints {numbers} ({names}) look {STATES[kind]}"

    def with_offset(self, joint: int, offset: float) -> "ColumnHypothesis":
        """Return the same with another offset of a joint [rad]."""
        offsets = self.offsets.copy()
        offsets[joint] = offset
        return replace(self, offsets=offsets)


def unchanged(robot: Robot) -> ColumnHypothesis:
    """Return the hypothesis of correct columns."""
    m = len(robot.actuated)
    return ColumnHypothesis(robot, np.arange(m), np.ones(m), np.zeros(m))


def signs(robot: Robot, count: int) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that so many joints have the other sign."""
    as_recorded = unchanged(robot)
    for joints in combinations(as_recorded.order, count):
        is_flipped = np.isin(as_recorded.order, joints)
        yield replace(as_recorded, signs=np.where(is_flipped, -1.0, 1.0))


def swaps(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that two columns are exchanged."""
    as_recorded = unchanged(robot)
    for i, j in combinations(as_recorded.order.tolist(), 2):
        order = as_recorded.order.copy()
        order[[i, j]] = j, i
        yield replace(as_recorded, order=order)


def other_orders(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that columns begin at the tip, or at another joint."""
    as_recorded = unchanged(robot)
    order = as_recorded.order
    yield replace(as_recorded, order=order[::-1])
    for k in range(1, len(order)):
        yield replace(as_recorded, order=np.roll(order, k))
