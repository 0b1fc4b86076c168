"""Hypotheses on columns that are not the model's joints: signs, swaps and offsets.

Offsets of several joints are too many to try one by one. But the ball's centre is smooth in them,
so Gauss-Newton steps find them from a few starts.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..robot import Robot
from .robust_fit import RigidModel, Samples

STEPS = 8
MAX_STEP = 0.2
"""Largest change of an offset in a step [rad]."""
MAX_MISTAKES = 3
"""Mistakes of a recording at most; a model that needs more is another robot's."""
USUAL_OFFSET = np.deg2rad(1.5)
"""Joints may be off by less than this."""
NEEDED = 1.5
"""The error without an offset that is needed is so many times as large as with it."""
ADVICE = {
    "sign": "change the sign in the recording, or of the axis in the model",
    "swap": "bring the columns into the order of the model's chain",
    "order": "bring the columns into the order of the model's chain",
    "zero": "set the joint's zero, or choose the model of this robot's version",
}


@dataclass(frozen=True)
class ColumnHypothesis:
    """Joint positions as they may truly be: q[order] * signs - offsets."""

    robot: Robot
    order: np.ndarray
    signs: np.ndarray
    offsets: np.ndarray

    def apply(self, samples: Samples) -> Samples:
        """Return samples as they would be."""
        q = samples.positions[:, self.order] * self.signs - self.offsets
        return Samples(q, samples.sockets)

    @property
    def mistakes(self) -> dict[str, list[int]]:
        """Joints that it blames, by ``sign``, ``swap`` and ``zero``; no kind without any."""
        joints = {
            "sign": np.flatnonzero(self.signs < 0),
            "swap": np.flatnonzero(self.order != np.arange(len(self.order))),
            "zero": np.flatnonzero(self.offsets),
        }
        return {kind: found.tolist() for kind, found in joints.items() if len(found)}

    @property
    def code(self) -> str:
        """The first kind of mistake, ``sign`` before ``swap`` before ``zero``."""
        return next(iter(self.mistakes))

    @property
    def name(self) -> str:
        """Name of the explanation: an ``order`` is a swap of more than two."""
        many = len(self.mistakes.get("swap", ())) > 2
        return "order" if many and self.code == "swap" else self.code

    @property
    def text(self) -> str:
        """The mistakes, and what mends them."""
        mends = {"sign": "-q", "swap": "their columns put right", "zero": "that taken off"}
        words = " and ".join(self._words(*one) for one in self.mistakes.items())
        return f"{words}: with {' and '.join(mends[kind] for kind in self.mistakes)}"

    @property
    def advice(self) -> str:
        """Steps that mend the mistakes."""
        return "; ".join(ADVICE[kind] for kind in self.mistakes)

    def _words(self, kind: str, joints: Sequence[int]) -> str:
        how = {"sign": "sign-flipped", "swap": "swapped"}.get(kind)
        if kind == "swap" and len(joints) > 2:
            order = ", ".join(str(i + 1) for i in self.order.tolist())
            return f"the columns look out of order: {order}"
        off = " and ".join(f"{np.rad2deg(self.offsets[j]):+.1f}" for j in joints)
        return f"{_names(self.robot, joints)} {how or f'off by {off} deg'}"

    def with_offset(self, joint: int, offset: float) -> "ColumnHypothesis":
        """Return the same with another offset of a joint [rad]."""
        alone = np.arange(len(self.offsets)) == joint
        return replace(self, offsets=np.where(alone, offset, self.offsets))


def _names(robot: Robot, joints: Sequence[int]) -> str:
    numbers = " and ".join(str(joint + 1) for joint in joints)
    names = ", ".join(robot.joint_names[joint] for joint in joints)
    many = len(joints) > 1
    return f"joint{'s' * many} {numbers} ({names}) look{'s' * (not many)}"


def unchanged(robot: Robot) -> ColumnHypothesis:
    """Return the hypothesis that nothing is wrong."""
    m = len(robot.actuated)
    return ColumnHypothesis(robot, np.arange(m), np.ones(m), np.zeros(m))


def signs(robot: Robot, count: int) -> Iterator[ColumnHypothesis]:
    """Return the hypotheses that so many joints have the other sign."""
    right = unchanged(robot)
    for joints in combinations(range(len(robot.actuated)), count):
        flipped = right.signs.copy()
        flipped[list(joints)] = -1
        yield replace(right, signs=flipped)


def swaps(robot: Robot) -> Iterator[ColumnHypothesis]:
    """Return the hypotheses that two columns are exchanged."""
    right = unchanged(robot)
    for i, j in combinations(range(len(robot.actuated)), 2):
        order = right.order.copy()
        order[[i, j]] = j, i
        yield replace(right, order=order)


def several_offsets(
    model: RigidModel, samples: Samples, starts: Sequence[ColumnHypothesis], joints: Sequence[int]
) -> ColumnHypothesis | None:
    """Return the best hypothesis with offsets of some joints, each of them needed; None if none."""

    def error(hypothesis: ColumnHypothesis) -> float:
        return model.nominal_error(hypothesis.apply(samples))

    best = min((with_best_offsets(model, samples, start, joints) for start in starts), key=error)
    kept = list(joints)
    while kept:
        fewer = [
            with_best_offsets(
                model, samples, best.with_offset(joint, 0.0), [j for j in kept if j != joint]
            )
            for joint in kept
        ]
        simpler = min(fewer, key=error)
        if error(simpler) > NEEDED * error(best):
            break
        best, kept = simpler, [j for j in kept if simpler.offsets[j]]
    offsets = np.where(np.abs(best.offsets) < USUAL_OFFSET, 0.0, best.offsets)
    best = replace(best, offsets=offsets)
    count = int(np.count_nonzero(offsets)) + sum(kind != "zero" for kind in best.mistakes)
    return best if 0 < count <= MAX_MISTAKES else None


def with_best_offsets(
    model: RigidModel, samples: Samples, start: ColumnHypothesis, joints: Sequence[int]
) -> ColumnHypothesis:
    """Return a hypothesis with the best offsets of some joints near those it has."""
    offsets = start.offsets.copy()
    for _ in range(STEPS if joints else 0):
        step = model.nominal_offsets(replace(start, offsets=offsets).apply(samples), joints)
        offsets[list(joints)] += step * min(1.0, MAX_STEP / max(float(np.abs(step).max()), 1e-9))
    return replace(start, offsets=offsets)
