"""How a hand leads an arm from one configuration to the next, as a function of time.

A person holds the arm still at each configuration, then leads it to the next one along a
minimum-jerk path, which is how people move their hands (Flash and Hogan, 1985)::

    q(s) = a + (b - a) (10 s^3 - 15 s^4 + 6 s^5)

where a and b are the joint positions before and after the move [rad], and s is the share of the
move's time that has passed, from 0 to 1. Velocity and acceleration are zero at both ends, so that
nothing jumps.
"""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Motion:
    """Visits configurations in order, rests at each, and stays at the last one for good."""

    configurations: Sequence[Sequence[float]]
    """Joint positions at each rest [rad]: at least one configuration, all of the same length."""
    hold: float = 1.0
    """How long each rest lasts [s]."""
    move: float = 1.0
    """How long each move lasts [s]."""

    def __post_init__(self) -> None:
        if not self.configurations or len({len(q) for q in self.configurations}) != 1:
            raise ValueError("a motion needs configurations of one length, and at least one")
        if self.hold < 0 or self.move <= 0:
            raise ValueError("a motion needs hold >= 0 and move > 0")

    @property
    def duration(self) -> float:
        """Time from the start to the end of the last rest [s]."""
        count = len(self.configurations)
        return count * self.hold + (count - 1) * self.move

    def position(self, time: float) -> tuple[float, ...]:
        """Return the joint positions [rad] at a time after the start [s]."""
        index, progress = self.phase(time)
        here = self.configurations[index]
        if progress == 0:
            return tuple(here)
        there = self.configurations[index + 1]
        s = progress**3 * (10 + progress * (6 * progress - 15))
        return tuple([a + (b - a) * s for a, b in zip(here, there, strict=True)])

    def phase(self, time: float) -> tuple[int, float]:
        """Return the number of the last rest, and how far the move after it has come, 0 to 1."""
        index, within = divmod(max(time, 0.0), self.hold + self.move)
        if index >= len(self.configurations) - 1:
            return len(self.configurations) - 1, 0.0
        return int(index), max(0.0, within - self.hold) / self.move
