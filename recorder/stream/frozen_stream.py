"""Distinction of a frozen stream, which repeats an old state, from an arm at rest.

Sensors' noise goes to and fro, a motion goes on; a stream with neither counts as frozen.
"""

import math

from ...drivers import JointState

LONG = 0.25
"""Shortest repetition that can count as frozen [s]."""
SHORT = 0.02
"""An arm rested if it sent the same for this long [s] and then went on with a small step."""
GOES_ON = 1e-3
"""The largest such step [rad]; a stream with a coarser resolution may go on by a step of that."""
USUAL = 3
"""After this many rests with exactly the same numbers, a stream is known to have no noise, so that
sameness is no sign that it is frozen."""
ENOUGH_STEPS = 100
"""Steps between states after which a stream's noise can be judged."""
NOISY = 0.3
"""A stream is noisy where at least this share of its steps reverses the step before."""
DEAD_STOP = 20.0
"""Deceleration that no arm led by hand reaches [rad/s^2]."""
SLOW = 0.05
"""Speed below which a sudden stop is no sign [rad/s]."""


class FrozenStreamDetector:
    """Detector of a frozen stream, fed state by state."""

    def __init__(self, resolution: float = 0.0) -> None:
        self._goes_on = max(GOES_ON, 1.5 * resolution)
        self.frozen = False
        """True while the stream is frozen."""
        self._since = math.nan
        self._stopped_dead = False
        self._rests = 0
        self._steps = self._turns = 0
        self._step: tuple[float, ...] = ()
        self._speed = self._last_speed = 0.0

    def feed(self, before: JointState, state: JointState) -> None:
        """Take in two states, one after the other."""
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
            noisy = self._steps >= ENOUGH_STEPS and self._turns > NOISY * self._steps
            noisy = noisy and self._rests < USUAL
            self.frozen = self.frozen or noisy or self._stopped_dead

    def _changes(self, before: JointState, state: JointState, elapsed: float) -> None:
        step = _difference(before.position, state.position)
        length = max(map(abs, step))
        if before.stamp - self._since >= SHORT and length < self._goes_on:
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
