"""Monitor of a stream: it averages sound states alone, and says why others are not."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from statistics import median

from ...drivers import TWO_SOURCES, JointState, JointValues, SourceDetector
from ...errors import fixed
from .. import TURN
from .stationarity import (
    STILL,
    WINDOW,
    FrozenStreamDetector,
    JointLimits,
    StationarityDetector,
    StationaryPose,
)

LOAD = 2.0
"""Deviation from the gravity torque that is always allowed [N m]."""
LOAD_SHARE = 0.1
"""Further deviation that is allowed, as a share of the gravity torque."""
TREMOR = 4.0
"""A torque may tremble by this many times its tremor at the quietest rest."""
LEAST_TREMOR = 0.1
"""Standard deviation of a torque that is always allowed [N m]."""


class ContactDetector:
    """Compares each rest with gravity, and with the quietest rest before.

    ``gravity`` returns each joint's torque [N m] at joint positions; None where the model has no
    masses.
    """

    def __init__(
        self,
        joints: Sequence[JointLimits],
        gravity: Callable[[Sequence[float]], Sequence[float]] | None = None,
    ) -> None:
        self._joints = tuple(joints)
        self._gravity = gravity
        self._quietest: JointValues | None = None

    def evidence(self, pose: StationaryPose) -> str | None:
        """Return the evidence that the arm is being pushed, in words; None without any."""
        effort, spread = pose.effort, pose.effort_spread
        if effort is None or spread is None:
            return None
        torques = self._gravity(pose.position) if self._gravity else effort
        for joint, tau, torque in zip(self._joints, effort, torques, strict=True):
            if abs(tau - torque) > LOAD + LOAD_SHARE * abs(torque):
                return f"{joint.name} exerts {fixed(tau - torque, 1, '+')} N m beyond gravity"
        quietest = self._quietest or spread
        self._quietest = tuple(map(min, quietest, spread))
        for joint, now, quiet in zip(self._joints, spread, quietest, strict=True):
            if now > max(LEAST_TREMOR, TREMOR * quiet):
                return f"the effort of {joint.name} trembles by {now:.2f} N m"
        return None


SILENT = 0.25
"""Longest pause of a stream that is alive [s], but for slow ones."""
STEPS = 5
"""The pace of a stream is the median of so many steps."""
SLOWER = 2.5
"""A slow stream is silent after this many of them."""
LATE = 0.5
"""Longest delay of a state in a stream that is not late [s]."""
DRIFT = 1e-3
"""Largest difference in speed between the robot's and the host's clock, as a share."""
JUMP = math.radians(3.0)
"""A smaller deviation from the expected position is no jump [rad], [m]."""
JUMP_ACCELERATION = 50.0
"""No hand accelerates a joint more than this [rad/s^2]; in slow streams it allows larger steps."""
MOST_TURNS = 4.5
"""No counter of turns gains or loses more of them between two states."""
UNEVEN = 0.05
"""Largest error of a stamp, where the host gives the stamps [s]."""
ABSURD = 1e6
"""No joint's position [rad] or effort [N m] is as large as this."""


class StreamMonitor(StationarityDetector):
    """Monitor of a stream, fed state by state; it averages none but sound ones, over a window [s].

    ``still`` is the largest deviation of a joint at rest, ``resolution`` the stream's smallest step
    [rad]; ``live`` makes a late stream a fault.
    """

    def __init__(
        self,
        joints: Sequence[JointLimits],
        window: float = WINDOW,
        still: float = STILL,
        *,
        live: bool = True,
        resolution: float = 0.0,
    ) -> None:
        super().__init__(joints, window, still)
        self.joints = tuple(joints)
        self.live = live
        self.arrival = -math.inf
        """Arrival of the last state, faulty or not, by the host's monotonic clock [s]."""
        self._arrivals: deque[float] = deque()
        self._pauses: deque[float] = deque(maxlen=STEPS)
        self._resolution = resolution
        self._delay = 0.0
        self._connection = 0
        self._reset()

    def feed(self, state: JointState, arrival: float, connection: int = 0) -> bool:
        """Take in a state; return whether the average was computed anew."""
        if connection != self._connection:
            self._connection = connection
            self._reset()
        if state.stamp == self._stamp:
            self._stood_since = min(self._stood_since, arrival)
        else:
            # The robot's clock stood, and goes on from there: the arm may have moved meanwhile.
            if (
                state.stamp > self._stamp
                and arrival - self._stood_since > self.patience
            ):
                self._reset()
            self._stood_since = math.inf
        self._count(arrival, state.stamp)
        self._sources.feed(state)
        fault = self._fault_of(state)
        self._stamp = state.stamp
        if fault:
            self._fault = fault
            self.restart()
            return False
        self._follow(state)
        self.latest = state
        looked = self.add(state)
        if self.full:
            self._fault = None
        return looked

    def rate(self, now: float) -> float:
        """Return the number of states within the last second."""
        while self._arrivals and self._arrivals[0] < now - 1.0:
            if self.age(now) <= self.patience:
                break
            self._arrivals.popleft()
        return float(len(self._arrivals))

    @property
    def patience(self) -> float:
        """The longest pause of this stream while it is alive [s]."""
        return max(SILENT, SLOWER * median(self._pauses)) if self._pauses else SILENT

    def age(self, now: float) -> float:
        """Return the time since the last state came [s]."""
        return now - self.arrival

    def trouble(self, now: float) -> str | None:
        """Return the reason why nothing may be captured now; None if something may."""
        return self.unsound(now) or (None if self.rest else self.moving)

    def unsound(self, now: float) -> str | None:
        """Return the reason why the stream cannot be trusted now; None if it can."""
        if self.age(now) > self.patience:
            age = self.age(now)
            silent = f"for {age:.1f} s" if math.isfinite(age) else "yet"
            return f"the stream is silent: no state {silent}"
        if self._sources.two_sources:
            return (
                f"{TWO_SOURCES}; stop one of them, or choose another topic or address"
            )
        if self._fault:
            return self._fault
        for joint, offset in zip(self.joints, self._offsets, strict=True):
            if abs(offset) > JUMP / 2:
                return (
                    f"{joint.name} jumped by {joint.shown(offset)} between two states and has not "
                    "come back; if the arm is right, end the session, and start again"
                )
        if self._frozen_stream.frozen:
            return "the stream is frozen: it repeats one state to the last digit"
        if self.live and self._delay > LATE:
            return f"the stream is stale: states come {self._delay:.1f} s late"
        return None

    def _reset(self) -> None:
        """Forget what came before, so that nothing is compared with it."""
        self.latest: JointState | None = None
        """The last state that was not faulty."""
        self._fault: str | None = None
        self._offsets = [0.0] * len(self.joints)
        self._speeds = [0.0] * len(self.joints)
        self._frozen_stream = FrozenStreamDetector(self._resolution)
        self._sources = SourceDetector()
        self._stamp = -math.inf
        self._stood_since = math.inf
        self._least_delay = math.inf
        self.restart()

    def _count(self, arrival: float, stamp: float) -> None:
        """Keep track of the stream's rate and delay."""
        pause = arrival - self.arrival
        self._arrivals.append(arrival)
        self._pauses.append(pause)
        while self._arrivals[0] < arrival - 1.0:
            self._arrivals.popleft()
        self.arrival = arrival
        if stamp < self._stamp:
            self._least_delay = math.inf
        delay = arrival - stamp
        allowed = DRIFT * pause if math.isfinite(pause) else 0.0
        self._least_delay = min(self._least_delay + allowed, delay)
        self._delay = delay - self._least_delay

    def _fault_of(self, state: JointState) -> str | None:
        """Return the fault of a state by itself, or after the one before."""
        if len(state.position) != len(self.joints):
            return f"{len(state.position)} joints came, but the model has {len(self.joints)}"
        if state.effort is not None and len(state.effort) != len(self.joints):
            return f"{len(state.effort)} efforts came, but the model has {len(self.joints)} joints"
        if broken := self._broken(state.position):
            return f"{broken}, which is no joint position"
        if state.effort is not None and (broken := self._broken(state.effort)):
            return f"effort of {broken}, which is no effort"
        if not math.isfinite(state.stamp):
            return f"the robot's stamp came as {state.stamp}"
        if not any(state.position):
            return "all joints read exactly 0: the controller is not up yet"
        if state.stamp == self._stamp:
            return "the robot's stamp does not advance: the same state came again"
        if not state.stamp > self._stamp:
            return "the robot's stamp went back"
        return None

    def _broken(self, values: Sequence[float]) -> str | None:
        for joint, value in zip(self.joints, values, strict=True):
            if not -ABSURD < value < ABSURD:  # true for NaN
                return f"{joint.name} came as {value}"
        return None

    def _follow(self, state: JointState) -> None:
        """Detect jumps and a frozen stream."""
        before = self.latest
        if before is None:
            return
        was_frozen = self._frozen_stream.frozen
        self._frozen_stream.feed(before, state)
        # The arm may have moved on meanwhile.
        if was_frozen and not self._frozen_stream.frozen:
            self.restart()
            return
        elapsed = state.stamp - before.stamp
        if elapsed <= 0:
            return
        limit = max(JUMP, JUMP_ACCELERATION * elapsed**2)
        for i, (old, new) in enumerate(
            zip(before.position, state.position, strict=True)
        ):
            expected = self._speeds[i] * elapsed
            allowed = max(limit, UNEVEN * abs(self._speeds[i]))
            surprise = new - old - expected
            if allowed < abs(surprise) < MOST_TURNS * TURN:  # whole turns are no jump
                deviation = self.joints[i].difference(surprise)
                surprise = deviation if abs(deviation) < allowed else surprise
            if abs(surprise) > allowed:
                self._offsets[i] += surprise
                self.restart()
            else:
                self._speeds[i] = (expected + surprise) / elapsed
