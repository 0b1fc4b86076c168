"""Stationarity of the arm, and the average over a window of an arm that is still."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

import numpy as np
from numpy.typing import NDArray

from ...drivers import JointState

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

    def shown(self, value: float) -> str:
        """Return a position, or a difference of positions, as people read it."""
        return f"{value * 1e3:.1f} mm" if self.prismatic else f"{math.degrees(value):.1f}°"


@dataclass(frozen=True, slots=True)
class StationaryPose:
    """The average over a window in which the arm was still."""

    position: tuple[float, ...]
    """Mean position of each joint [rad], [m] for a prismatic joint."""
    spread: tuple[float, ...]
    """Standard deviation of each joint's position [rad], [m]."""
    effort: tuple[float, ...] | None
    """Mean effort of each joint [N m]; None where the robot does not measure it."""
    effort_spread: tuple[float, ...] | None
    """Standard deviation of each joint's effort [N m]."""
    stamp: float
    """The robot's own time of the last state [s]."""
    states: int
    """Number of averaged states."""


class StationarityDetector:
    """Window of the last states, and their average while the arm is still."""

    def __init__(self, joints: Sequence[JointLimits], length: float, still: float) -> None:
        self._joints = tuple(joints)
        self._length = length
        self._still = still
        self._states: deque[JointState] = deque()
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
        states.append(state)
        while states[0].stamp < state.stamp - self._length * (1 + 1e-9):
            states.popleft()
        if state.stamp < self._next_check:
            return False
        self._next_check = state.stamp + CHECK_INTERVAL
        self.rest = self._average()
        if self.rest is None:
            self._still_since = math.nan
        elif math.isnan(self._still_since):
            self._still_since = state.stamp
        self.settled = state.stamp - self._still_since >= self._length
        return True

    def _average(self) -> StationaryPose | None:
        stamps = [state.stamp for state in self._states]
        steps = [b - a for a, b in pairwise(stamps)] or [math.inf]
        lacking = FULL_SHARE * self._length - (stamps[-1] - stamps[0])
        self.full = 2 * max(steps) <= self._length and (
            lacking <= 0 or lacking <= median(steps)  # the last step may end just outside
        )
        if not self.full:
            self.moving = "too few states yet: wait a moment"
            return None
        if len(stamps) < MIN_STATES:
            self.moving = f"only {len(stamps)} states in {self._length:g} s: use a longer --window"
            return None
        positions = np.array([state.position for state in self._states])
        spread = positions.std(axis=0)
        worst = int(spread.argmax())
        self.fast = bool(spread[worst] > FAST * self._still)
        if spread[worst] > self._still:
            joint = self._joints[worst]
            swing = float(np.ptp(positions[:, worst]))
            self.moving = f"still moving: {joint.name} by {joint.shown(swing)}"
            return None
        efforts = [state.effort for state in self._states if state.effort is not None]
        measured = np.array(efforts) if len(efforts) == len(stamps) else None
        return StationaryPose(
            position=_floats(positions.mean(axis=0)),
            spread=_floats(spread),
            effort=None if measured is None else _floats(measured.mean(axis=0)),
            effort_spread=None if measured is None else _floats(measured.std(axis=0)),
            stamp=stamps[-1],
            states=len(stamps),
        )


def _floats(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(values.tolist())
