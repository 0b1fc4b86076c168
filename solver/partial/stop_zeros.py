"""Zeros of joints by their stops, without a ball: a stop stays, and its reading tells the zero.

With a joint's readings l and u at both stops, and l', u' later, its zero moved by
((l' - l) + (u' - u)) / 2. Its range u - l stays, unless a stop was not reached or is another one.
"""

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass

from ...errors import fixed
from .zeros import JointZero

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
class StopZeros:
    """Zeros of an arm's joints by their stops."""

    joints: tuple[JointZero, ...]
    """All that both recordings tell, in chain order; the offset of one that did not change is 0."""
    untold: tuple[str, ...]
    """Why the other joints are not told, and whole turns, in words."""

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
"""What each joint reads at its lower and at its upper stop [rad]."""


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
