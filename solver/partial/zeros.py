"""A joint's zero that changed, or another arm."""

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import fixed
from .evidence import geometry_changes
from .fit import fit
from .prior import ZERO
from .system import System
from .task import Task

ZERO_CHANGED = 0.02
"""Prior probability that a joint's zero changed, where several may have."""
TICK = 2 * math.pi / 4096
"""Step of a servo with 4096 in a turn [rad]."""
ANOTHER, LESS = math.log(1000), 0.5
"""Log Bayes factor of a geometry that changed everywhere, and the share of the noise that it
leaves, from which samples are taken for another arm's."""
UNIDENTIFIABLE = 1e-2
"""Standard deviation beyond which a zero is not identifiable [rad], [m]."""
GIVE = math.radians(0.3)
"""Standard deviation of a reading at a stop, which gives way to the hand [rad]."""
NAMED = 3.5
"""Standard deviations beyond which a zero changed."""
SAME_RANGE = 6.0
"""Largest change of a range, as a multiple of GIVE; its standard deviation is 2 GIVE."""
LEAST_RANGE = math.radians(20)
"""A joint that was led through less was not led to its stops."""
TURN = 2 * math.pi


@dataclass(frozen=True)
class JointZero:
    """Estimate of the change of a joint's zero."""

    joint: str
    changed: float
    """Probability that it changed; 1 where it was named."""
    offset: float
    """To be added to what the joint reads [rad], [m]; 0 where it did not change."""
    standard_deviation: float
    """Of the offset [rad], [m]; of one that did not change, were it to be found alone."""

    @property
    def told(self) -> bool:
        """True if the samples can identify it."""
        return self.standard_deviation < UNIDENTIFIABLE

    @property
    def degrees(self) -> float:
        """The offset [deg]."""
        return math.degrees(self.offset)

    @property
    def brief(self) -> str:
        """Offset to add to its readings, in a line."""
        offset = f"{fixed(self.offset, 5, '+')} +- {self.standard_deviation:.5f} rad"
        return f"{self.joint}: add {offset} ({fixed(self.degrees, 3, '+')} deg) to what it reads."

    def __str__(self) -> str:
        offset = f"{fixed(self.offset, 6, '+')} +- {self.standard_deviation:.6f} rad"
        counts, homing = fixed(self.counts, 0, "+"), fixed(-self.counts, 0, "+")
        degrees = fixed(self.degrees, 4, "+")
        return (
            f"{self.joint}: {offset} to be added to what it reads ({degrees} deg; of a "
            f"servo with 4096 counts a turn {counts}, its homing_offset {homing} "
            f"(Feetech), {counts} (Dynamixel))"
        )

    @property
    def counts(self) -> int:
        """The offset in whole counts of a servo."""
        return round(self.offset / TICK)


def fit_with_zeros(task: Task, joints: Sequence[int] | np.ndarray) -> System:
    """Return the fit with the zeros of some joints as further unknowns."""
    zeros = task.prior.zeros[np.asarray(joints, dtype=int)]
    return fit(task.freeing(dict.fromkeys(zeros, ZERO)))


def zero_deviations(system: System) -> np.ndarray:
    """Return the standard deviation of each joint's zero, if it alone may have changed."""
    A = system.slopes[:, system.task.prior.zeros]
    white, _ = system.whitened(A, system.state.noise, gaussian=True)
    information = np.sum(white**2, axis=0)
    return 1 / np.sqrt(information + ZERO**-2)


def another_arm(system: System) -> tuple[str, ...]:
    """Return a warning where a different arm explains the samples far better, else nothing."""
    with_geometry = fit(system.task.freeing(geometry_changes(system.task)))
    scatter, least = system.state.noise.place, with_geometry.state.noise.place
    gain = with_geometry.log_evidence() - system.log_evidence()
    if gain < ANOTHER or least > LESS * scatter:
        return ()
    return (
        f"The samples scatter by {1e3 * scatter:.2f} mm an axis, and by {1e3 * least:.2f} if the "
        "whole arm may differ: is this another arm's calibration or model, or did more change?",
    )


@dataclass(frozen=True)
class StopZeros:
    """Zeros of an arm's joints by their stops."""

    joints: tuple[JointZero, ...]
    """All that both recordings tell, in chain order; the offset of one that did not change is 0."""
    untold: tuple[str, ...]
    """Reasons for which the other joints are not told, and whole turns, in words."""

    @property
    def changed(self) -> tuple[JointZero, ...]:
        """The joints whose zero changed."""
        return tuple(zero for zero in self.joints if zero.offset)

    @property
    def text(self) -> tuple[str, ...]:
        """The result in words, line by line."""
        steady = [zero.joint for zero in self.joints if not zero.offset]
        names = [f"No change: {', '.join(steady)}."] if steady else []
        return (*map(str, self.changed), *names, *self.untold)


Ranges = Mapping[str, tuple[float, float]]
"""Readings of each joint at its lower and at its upper stop [rad]."""


def zeros_by_stops(
    before: Ranges, after: Ranges, wrapped: Container[str] = ()
) -> StopZeros:
    """Return the zeros of joints by what they read at their stops.

    Args:
        before: On the day of the calibration.
        after: Now.
        wrapped: Joints whose reading now jumps by a turn on the way.
    """
    zeros: list[JointZero] = []
    words: list[str] = []
    for joint, (low, high) in before.items():
        if joint not in after:
            words.append(f"{joint}: not led to its stops; not told.")
            continue
        low_now, high_now = after[joint]
        doubt = _doubt(high - low, high_now - low_now)
        if doubt:
            words.append(f"{joint}: {doubt}; not told.")
            continue
        change = (low_now - low + high_now - high) / 2
        turns = round(change / TURN)
        change -= turns * TURN
        if turns:
            number = fixed(turns, 0, "+")
            words.append(f"{joint}: reads {number} whole turn beside its zero.")
        if joint in wrapped:
            words.append(
                f"{joint}: its reading jumps by a whole turn within its range: give its servo a "
                "homing offset by which it does not."
            )
        is_changed = abs(change) > NAMED * GIVE
        offset = -change if is_changed else 0.0
        zeros.append(JointZero(joint, float(is_changed), offset, GIVE))
    return StopZeros(tuple(zeros), tuple(words))


def _doubt(before: float, after: float) -> str:
    """Return why ranges tell no zero [rad]; empty where they do."""
    if min(before, after) < LEAST_RANGE:
        return "not led to its stops"
    if max(before, after) > TURN:
        return "turns on and on, so it has no stops"
    wider = after - before
    if abs(wider) > SAME_RANGE * GIVE:
        degrees = fixed(math.degrees(wider), 1, "+")
        return f"its range is {degrees} deg of what it was: lead it to both stops again"
    return ""
