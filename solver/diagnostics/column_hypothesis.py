"""Hypotheses on columns of joint positions: signs, ratios, orders, couplings and offsets."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, permutations, product
from typing import NamedTuple

import numpy as np

from ...errors import fixed
from ...recorder import around
from ..identification.robot import Robot
from .hypotheses import SeatSamples

STATES = {
    "sign": "sign-flipped",
    "swap": "swapped",
    "ratio": "wrongly geared",
    "coupled": "coupled",
    "zero": "off",
}
"""Looks of joints, by the kind of the mistake."""
GEARS = np.array([2.0, 3.0, 4.0, 5.0, 6.0, 10.0])
"""Factors by which a joint may read too little, or too much."""
GAINS = np.arange(0.04, 0.41, 0.02)
"""Shares by which it may."""
RATIOS = np.concatenate([GEARS, 1 / GEARS, 1 + GAINS, 1 - GAINS])
NEAR_RATIO = np.arange(0.98, 1.021, 0.002)
"""Factors on one of these, among which it is sought more closely."""
TWOFOLD = np.array([2.0, 0.5])
"""Factors among those that are tried beside other mistakes."""
QUARTERS = (-np.pi / 2, np.pi / 2, np.pi)
"""Offsets that are tried beside other mistakes [rad]."""
SHARES = (1.0, -1.0, 0.5, -0.5)
"""Shares of another joint's reading that one may lack."""


class Coupling(NamedTuple):
    """A joint that reads less than its angle by a share of what another joint reads."""

    joint: int
    other: int
    share: float


@dataclass(frozen=True)
class ColumnHypothesis:
    """Hypothesis that the true joint positions are q[order] * factors - offsets.

    To one of them a share of another's is added, where they are coupled.
    """

    robot: Robot
    order: np.ndarray
    factors: np.ndarray
    """-1 for another sign, and the ratio of a wrong gear."""
    offsets: np.ndarray
    coupling: Coupling | None = None

    def apply(self, samples: SeatSamples) -> SeatSamples:
        """Return samples as they would be."""
        q = samples.q[:, self.order] * self.factors - self.offsets
        if self.coupling is not None:
            joint, other, share = self.coupling
            # half a whole turn would count
            q[:, joint] += share * around(q[:, other], [True])
        return replace(samples, q=q)

    @property
    def mistakes(self) -> dict[str, list[int]]:
        """Joints that it blames, by ``sign``, ``swap`` and ``zero``; no kind without any."""
        in_order = np.arange(len(self.order))
        joints = {
            "sign": np.flatnonzero(self.factors < 0).tolist(),
            "ratio": np.flatnonzero(np.abs(self.factors) != 1).tolist(),
            "swap": np.flatnonzero(self.order != in_order).tolist(),
            "coupled": [] if self.coupling is None else list(self.coupling[:2]),
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
        geared = self.factors[mistakes.get("ratio", [])]
        joints = mistakes.get("zero", ())
        degrees = [fixed(np.rad2deg(-self.offsets[joint]), 1, "+") for joint in joints]
        readings = "it reads" if len(joints) == 1 else "they read"
        mends = {
            "sign": "the other sign",
            "ratio": " and ".join(f"{abs(factor):.3g} q" for factor in geared),
            "swap": "their columns put right",
            "zero": f"{' and '.join(degrees)} deg added to what {readings}",
        }
        if self.coupling is not None:
            names = self.robot.joint_names
            joint, other, share = self.coupling
            part = f"{abs(share):g} {names[other]}".removeprefix("1 ")
            sign = "+" if share > 0 else "-"
            mends["coupled"] = f"{names[joint]} {sign} {part} for {names[joint]}"
        blames = [self._blame(kind, indices) for kind, indices in mistakes.items()]
        mending = [mends[kind] for kind in mistakes]
        return f"{' and '.join(blames)}: with {' and '.join(mending)}"

    @property
    def columns(self) -> str:
        """Columns in the joints' order and with their signs, as ``--columns`` takes them."""
        pairs = zip(self.order.tolist(), self.factors.tolist(), strict=True)
        return "q=" + ",".join(f"{'-' * (factor < 0)}{i + 1}" for i, factor in pairs)

    def _blame(
        self,
        kind: str,
        joints: Sequence[int],
    ) -> str:
        if kind == "swap" and len(joints) > 2:
            order = ", ".join(map(str, self.order + 1))
            return f"the columns look out of order: {order}"
        numbers = " and ".join(str(joint + 1) for joint in joints)
        names = ", ".join(self.robot.joint_names[joint] for joint in joints)
        if len(joints) == 1:
            return f"joint {numbers} ({names}) looks {STATES[kind]}"
        return f"joints {numbers} ({names}) look {STATES[kind]}"

    def with_offset(
        self,
        joint: int,
        offset: float,
    ) -> "ColumnHypothesis":
        """Return the same with another offset of a joint [rad]."""
        offsets = self.offsets.copy()
        offsets[joint] = offset
        return replace(self, offsets=offsets)


def unchanged(robot: Robot) -> ColumnHypothesis:
    """Return the hypothesis of correct columns."""
    m = len(robot.actuated)
    return ColumnHypothesis(robot, np.arange(m), np.ones(m), np.zeros(m))


def signs(
    robot: Robot,
    count: int,
) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that so many joints have the other sign."""
    as_recorded = unchanged(robot)
    for joints in combinations(as_recorded.order, count):
        is_flipped = np.isin(as_recorded.order, joints)
        yield replace(as_recorded, factors=np.where(is_flipped, -1.0, 1.0))


def swaps(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that two columns are exchanged."""
    as_recorded = unchanged(robot)
    for i, j in combinations(as_recorded.order.tolist(), 2):
        order = as_recorded.order.copy()
        order[[i, j]] = j, i
        yield replace(as_recorded, order=order)


def any_signs(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that some joints, but not all, have the other sign."""
    for count in range(len(robot.actuated)):
        yield from signs(robot, count)


def signs_and_swaps(robot: Robot) -> Iterator[list[ColumnHypothesis]]:
    """Yield for any signs the hypotheses that two columns are exchanged, or none."""
    exchanged = list(swaps(robot))
    for flipped in any_signs(robot):
        yield [flipped, *(replace(flipped, order=h.order) for h in exchanged)]


def signs_and_quarter_turns(
    robot: Robot,
    joints: Sequence[int],
) -> Iterator[list[ColumnHypothesis]]:
    """Yield for any signs the hypotheses that one or two joints are off by quarter turns, too."""
    single = list(product(joints, QUARTERS))
    for flipped in any_signs(robot):
        off = [flipped.with_offset(*offset) for offset in single]
        pairs = product(off, single)
        yield off + [h.with_offset(*o) for h, o in pairs if not h.offsets[o[0]]]


def signs_swaps_and_ratios(robot: Robot) -> Iterator[list[ColumnHypothesis]]:
    """Yield for any signs the same with one column read twice or half as large."""
    joints = range(len(robot.actuated))
    for starts in signs_and_swaps(robot):
        geared = (with_ratios(start, joints, TWOFOLD) for start in starts)
        yield list(chain.from_iterable(geared))


def other_orders(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that columns begin at the tip, or at another joint."""
    as_recorded = unchanged(robot)
    order = as_recorded.order
    yield replace(as_recorded, order=order[::-1])
    for k in range(1, len(order)):
        yield replace(as_recorded, order=np.roll(order, k))


def two_swaps(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that two pairs of columns are exchanged, one pair after the other."""
    for first, second in combinations(swaps(robot), 2):
        yield replace(first, order=first.order[second.order])


def with_ratios(
    start: ColumnHypothesis,
    joints: Sequence[int],
    ratios: np.ndarray,
) -> Iterator[ColumnHypothesis]:
    """Yield a hypothesis with each of some joints that reads too little or too much by a ratio."""
    for joint, ratio in product(joints, ratios.tolist()):
        factors = start.factors.copy()
        factors[joint] *= ratio
        yield replace(start, factors=factors)


def couplings(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Yield the hypotheses that a joint reads a sum of its angle and another's, or a half of it."""
    as_recorded = unchanged(robot)
    pairs = permutations(as_recorded.order.tolist(), 2)
    for (joint, other), share in product(pairs, SHARES):
        yield replace(as_recorded, coupling=Coupling(joint, other, share))
