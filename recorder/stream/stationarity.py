"""Detectors of an arm that is still, with its average, and of a frozen stream."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import mul, sub
from statistics import median

import numpy as np

from ...drivers import JointState, JointValues
from .. import TURN, within, without_turn

WINDOW = 0.3
"""Default length of the average of a capture [s]."""
STILL = 5e-4
"""Default for the largest standard deviation of a joint of an arm that is still [rad], [m] for a
prismatic joint."""
CHECK_INTERVAL = 0.02
"""Interval of the checks [s]."""
MIN_STATES = 5
"""The fewest states that are averaged."""
FAST = 20.0
"""A spread this many times that of a still arm means that somebody leads the arm on."""
FULL_SHARE = 0.9
"""A window counts as full once its states and one step more span this share of its length."""


@dataclass(frozen=True, slots=True)
class JointLimits:
    """An actuated joint of the model and its limits."""

    name: str
    lower: float = -math.inf
    """Lower limit [rad], [m] for a prismatic joint; infinite for a continuous one."""
    upper: float = math.inf
    """Upper limit, likewise."""
    prismatic: bool = False

    @property
    def unit(self) -> str:
        """Unit of its position in files."""
        return "m" if self.prismatic else "rad"

    def difference(self, value: float) -> float:
        """Return a difference of positions, without whole turns."""
        return value if self.prismatic else without_turn(value)

    def allows(self, value: float, margin: float) -> bool:
        """Return whether a position is inside the limits, or some whole turns on."""
        lower, upper = self.lower - margin, self.upper + margin
        inside = lower <= value <= upper
        return inside or (not self.prismatic and within(value, lower, upper))

    def shown(self, value: float) -> str:
        """Return a position, or a difference of positions, as people read it."""
        return (
            f"{value * 1e3:.1f} mm" if self.prismatic else f"{math.degrees(value):.1f}°"
        )

    def rounded(self, value: float) -> int:
        """Return a difference of positions in whole degrees or millimetres, as a hand follows."""
        return round(1e3 * value if self.prismatic else math.degrees(value))

    def turned(self, value: float) -> str:
        """Return such a difference in words, as in ``up by 70°``."""
        way, unit = "up" if value > 0 else "down", " mm" if self.prismatic else "°"
        return f"{way} by {abs(self.rounded(value))}{unit}"


@dataclass(frozen=True, slots=True)
class StationaryPose:
    """The average over a window in which the arm was still."""

    position: JointValues
    """Mean position of each joint [rad], [m] for a prismatic joint."""
    spread: JointValues
    """Standard deviation of each joint's position [rad], [m]."""
    effort: JointValues | None
    """Mean effort of each joint [N m]; None where the robot does not measure it."""
    effort_spread: JointValues | None
    """Standard deviation of each joint's effort [N m]."""
    stamp: float
    """The robot's own time of the last state [s]."""
    states: int
    """Number of averaged states."""


class StationarityDetector:
    """Window of the last states, and their average while the arm is still."""

    def __init__(
        self, joints: Sequence[JointLimits], length: float, still: float
    ) -> None:
        self._joints = tuple(joints)
        self._turn = np.array([0.0 if joint.prismatic else TURN for joint in joints])
        self.length = length
        self._still = still
        self._states: deque[JointState] = deque()
        self._steps: deque[float] = deque(maxlen=MIN_STATES)
        self.restart()

    def restart(self) -> None:
        """Forget all states, so that none from before is averaged with one from after."""
        self._states.clear()
        self._next_check = -math.inf
        self._still_since = math.nan
        self.rest: StationaryPose | None = None
        """The average, while the arm is still; else None."""
        self.settled = False
        """True once the arm has been still for longer than a whole window."""
        self.full = False
        """True once the window is full."""
        self.fast = False
        """True while the arm moves so fast that somebody leads it on."""
        self.moving = "too few states yet: wait a moment"
        """Reason why there is no average."""

    def add(self, state: JointState) -> bool:
        """Take in a state; return whether the average was computed anew."""
        states = self._states
        if states:
            self._steps.append(state.stamp - states[-1].stamp)
        states.append(state)
        while states[0].stamp < state.stamp - self.length * (1 + 1e-9):
            states.popleft()
        if state.stamp < self._next_check:
            return False
        self._next_check = state.stamp + CHECK_INTERVAL
        self.rest = self._average()
        if self.rest is None:
            self._still_since = math.nan
        elif math.isnan(self._still_since):
            self._still_since = state.stamp
        self.settled = state.stamp - self._still_since >= self.length
        return True

    def _average(self) -> StationaryPose | None:
        stamps = [state.stamp for state in self._states]
        steps = [b - a for a, b in pairwise(stamps)] or [math.inf]
        lacking = FULL_SHARE * self.length - (stamps[-1] - stamps[0])
        # the last step may end just outside
        self.full = 2 * max(steps) <= self.length and lacking <= median(steps)
        self.moving = "too few states yet: wait a moment"
        step = min(self._steps, default=math.inf)
        slow = 2 * step > self.length and len(self._steps) == MIN_STATES
        if len(stamps) < MIN_STATES and (self.full or slow):
            shortest = math.ceil(10 * (MIN_STATES + 0.5) * step - 1e-6) / 10
            self.moving = (
                f"only {len(stamps)} states in {self.length:g} s: "
                f"use a longer --window, {shortest:g}"
            )
            return None
        if not self.full:
            return None
        positions = np.array([state.position for state in self._states])
        turns = np.rint((positions - positions[0]) / TURN)
        positions -= turns * self._turn
        spread = positions.std(axis=0)
        worst = int(spread.argmax())
        self.fast = bool(spread[worst] > FAST * self._still)
        if spread[worst] > self._still:
            joint = self._joints[worst]
            swing = float(np.ptp(positions[:, worst]))
            self.moving = f"still moving: {joint.name} by {joint.shown(swing)}"
            return None
        effort = effort_spread = None
        if all(state.effort is not None for state in self._states):
            efforts = np.array([state.effort for state in self._states])
            effort = tuple(efforts.mean(axis=0).tolist())
            effort_spread = tuple(efforts.std(axis=0).tolist())
        position = tuple(positions.mean(axis=0).tolist())
        spreads = tuple(spread.tolist())
        return StationaryPose(
            position,
            spreads,
            effort,
            effort_spread,
            stamp=stamps[-1],
            states=len(stamps),
        )


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
        self._step: JointValues = ()
        self._speed = self._last_speed = 0.0

    def feed(self, before: JointState, state: JointState) -> None:
        """Take in two states, one after the other."""
        elapsed = max(state.stamp - before.stamp, 1e-6)
        if state.position == before.position and state.effort == before.effort:
            if math.isnan(self._since):
                self._since = before.stamp
                speed = min(self._speed, self._last_speed)
                self._stopped_dead = speed > max(SLOW, DEAD_STOP * elapsed)
            if state.stamp - self._since >= LONG:
                noisy = (
                    self._steps >= ENOUGH_STEPS and self._turns > NOISY * self._steps
                )
                noisy = noisy and self._rests < USUAL
                self.frozen = self.frozen or noisy or self._stopped_dead
            return
        step = tuple(map(sub, state.position, before.position))
        length = max(map(abs, step))
        if before.stamp - self._since >= SHORT and length < self._goes_on:
            self._rests += 1
        self._since = math.nan
        self.frozen = False
        self._last_speed = length / elapsed
        # smoothed over some ten states, so that noise alone makes no speed
        self._speed += 0.1 * (self._last_speed - self._speed)
        if before.effort is not None and state.effort is not None:
            step += tuple(map(sub, state.effort, before.effort))
        self._steps += 1
        products = map(mul, step, self._step)
        self._turns += min(products, default=0.0) < 0
        self._step = step
