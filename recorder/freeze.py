"""Tells a stream that is frozen from an arm that rests.

Some arms deliver sensor noise, so that no two states are the same; others round it away, and
repeat the same numbers while they rest. Noise shows by steps that go to and fro; a motion goes on.
A stream counts as frozen when its states are the same to the last digit for :data:`LONG` and

* it is noisy, and has hardly ever stood so still before, or
* it stopped dead: an arm that moved at the state before cannot stand at the next.
"""

import math

from ..drivers import JointState

__all__ = ["Freeze"]

LONG = 0.25
"""How long a stream repeats itself before it can count as frozen [s]."""
SHORT = 0.02
"""Repeating itself for this long [s] is a rest, if the arm then goes on from where it stood."""
GOES_ON = 1e-3
"""How far the first step after a rest goes at most [rad]."""
USUAL = 3
"""A stream that has rested so often does so in good health."""
SEEN = 100
"""Nothing is known of a stream's noise before so many steps."""
NOISY = 0.3
"""A stream is noisy where this share of its steps turns back on the step before."""
DEAD_STOP = 20.0
"""Deceleration that no arm led by hand reaches [rad/s^2]."""
SLOW = 0.05
"""Speed below which a stop says nothing [rad/s]."""


class Freeze:
    """Follows a stream from state to state."""

    def __init__(self) -> None:
        self.frozen = False
        """Whether it is frozen now."""
        self._since = math.nan
        self._stopped_dead = False
        self._rests = 0
        self._steps = self._turns = 0
        self._step: tuple[float, ...] = ()
        self._speed = self._last_speed = 0.0

    def feed(self, before: JointState, state: JointState) -> None:
        """Take two consecutive states in."""
        elapsed = max(state.stamp - before.stamp, 1e-6)
        if state.position == before.position and state.effort == before.effort:
            self._repeats(before, state, elapsed)
        else:
            self._changes(before, state, elapsed)

    def _repeats(self, before: JointState, state: JointState, elapsed: float) -> None:
        if math.isnan(self._since):
            self._since = before.stamp
            speed = min(self._speed, self._last_speed)
            self._stopped_dead = speed > max(SLOW, DEAD_STOP * elapsed)
        if state.stamp - self._since >= LONG:
            noisy = self._steps >= SEEN and self._turns > NOISY * self._steps
            noisy = noisy and self._rests < USUAL
            self.frozen = self.frozen or noisy or self._stopped_dead

    def _changes(self, before: JointState, state: JointState, elapsed: float) -> None:
        step = _difference(before.position, state.position)
        length = max(map(abs, step))
        if before.stamp - self._since >= SHORT and length < GOES_ON:
            self._rests += 1
        self._since = math.nan
        self.frozen = False
        self._last_speed = length / elapsed
        # smoothed over some ten states, so that noise alone makes no speed
        self._speed += 0.1 * (self._last_speed - self._speed)
        if before.effort is not None and state.effort is not None:
            step += _difference(before.effort, state.effort)
        self._steps += 1
        self._turns += any(a * b < 0 for a, b in zip(step, self._step, strict=False))
        self._step = step


def _difference(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, ...]:
    return tuple([y - x for x, y in zip(a, b, strict=True)])
