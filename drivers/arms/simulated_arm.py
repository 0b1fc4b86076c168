"""A simulated arm: a hand-guided motion with encoder and torque noise and faults; no kinematics."""

import math
import random
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

from .. import JointNames, JointState, JointValues, clock

ARM_FAULTS = (
    "drop",
    "silent",
    "freeze",
    "repeat",
    "nan",
    "jump",
    "zeros",
    "short",
    "push",
)
"""Kinds of faults of the simulated arm; the documentation's page on simulation describes each."""


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault that lasts for a while."""

    kind: str
    share: float = 1.0
    """Share of the messages that it affects, above 0 and at most 1."""
    start: float = 0.0
    """Time at which it begins [s]."""
    duration: float = math.inf
    """[s]"""

    @classmethod
    def parse(
        cls, text: str, kinds: Collection[str] = ARM_FAULTS, duration: float = 0.5
    ) -> "Fault":
        """Return the fault that ``KIND[:SHARE][@START[+DURATION]]`` names, as in ``nan@3.5+0.2``.

        Raises ValueError where it names none; ``duration`` is for one without [s].
        """
        what, _, when = text.partition("@")
        kind, _, share = what.partition(":")
        start, _, length = when.partition("+")
        try:
            fault = cls(
                kind, float(share or 1), float(start or 0), float(length or duration)
            )
        except ValueError:
            raise ValueError(
                f"fault {text!r}: expected KIND[:SHARE][@START[+DURATION]], as in drop:0.05@2+3"
            ) from None
        if kind not in kinds or not 0 < fault.share <= 1:
            raise ValueError(
                f"fault {text!r}: the share is from 0 to 1, and the kind one of {', '.join(kinds)}"
            )
        return fault

    def is_active(self, moment: float) -> bool:
        """Return whether the fault lasts at a moment [s]."""
        return self.start <= moment < self.start + self.duration

    def affects(self, moment: float, generator: random.Random) -> bool:
        """Return whether the fault affects a message at a moment [s], by its share."""
        return self.is_active(moment) and (
            self.share == 1 or generator.random() < self.share
        )


@dataclass(frozen=True)
class Motion:
    """A hand-guided motion: it visits configurations in order, rests at each, stays at the last.

    A person leads an arm along minimum-jerk paths, as people move their hands (Flash and Hogan,
    1985)::

        q(s) = a + (b - a) (10 s^3 - 15 s^4 + 6 s^5)

    with the joint positions a before and b after the move [rad], and the share s of the move's time
    that has passed, 0 to 1. Velocity and acceleration are zero at both ends.
    """

    configurations: Sequence[Sequence[float]]
    """Joint positions at each rest [rad]: at least one configuration, all of the same length."""
    hold: float = 1.0
    """Duration of each rest [s]."""
    move: float = 1.0
    """Duration of each move [s]."""

    def __post_init__(self) -> None:
        if not self.configurations or len({len(q) for q in self.configurations}) != 1:
            raise ValueError(
                "a motion needs configurations of one length, and at least one"
            )
        if self.hold < 0 or self.move <= 0:
            raise ValueError("a motion needs hold >= 0 and move > 0")

    @property
    def duration(self) -> float:
        """Time from the start to the end of the last rest [s]."""
        count = len(self.configurations)
        return count * self.hold + (count - 1) * self.move

    def position(self, time: float) -> JointValues:
        """Return the joint positions [rad] at a time after the start [s]."""
        index, progress = self.phase(time)
        start = self.configurations[index]
        if progress == 0:
            return tuple(start)
        end = self.configurations[index + 1]
        s = progress**3 * (10 + progress * (6 * progress - 15))
        return tuple([a + (b - a) * s for a, b in zip(start, end, strict=True)])

    def phase(self, time: float) -> tuple[int, float]:
        """Return the number of the last rest, and how far the move after it has come, 0 to 1."""
        index, within = divmod(max(time, 0.0), self.hold + self.move)
        if index >= len(self.configurations) - 1:
            return len(self.configurations) - 1, 0.0
        return int(index), max(0.0, within - self.hold) / self.move


@dataclass
class SimulatedArm:
    """An arm that moves from the first connection on, whether or not anyone is still connected."""

    motion: Motion
    """Path through its configurations."""
    joint_names: JointNames = ()
    """Names of the joints; joint1, joint2, ... where none are given."""
    efforts: Sequence[Sequence[float]] | None = None
    """Torque of each joint at each of the motion's configurations [N m], shape (configurations,
    joints); None for an arm without torque sensors."""
    rate: float = 1000.0
    """States per second of the arm's time [Hz]."""
    noise: float = 2e-5
    """Standard deviation of the encoder noise [rad]."""
    effort_noise: float = 0.02
    """Standard deviation of the torque sensors' noise [N m]."""
    seed: int = 0
    """Seed of the noise: the same seed gives the same noise."""
    speed: float = 1.0
    """Seconds of the arm's time that pass in one second."""
    buffer: float = math.inf
    """Length of the stream that waits for a late reader [s]; older states are lost."""
    faults: Sequence[Fault] = ()
    """Faults, one of :data:`ARM_FAULTS` each."""

    def __post_init__(self) -> None:
        if not (
            self.rate > 0 and self.speed > 0 and self.noise >= 0 and self.buffer > 0
        ):
            raise ValueError(
                "rate, speed and buffer must be positive, and noise not negative"
            )
        if not self.joint_names:
            count = len(self.motion.configurations[0])
            self.joint_names = tuple(f"joint{i + 1}" for i in range(count))
        self._random = random.Random(self.seed)  # noqa: S311 - noise, no secret
        self._started = math.nan
        self._frozen: JointState | None = None
        efforts = self.efforts
        self._effort = (
            None if efforts is None else replace(self.motion, configurations=efforts)
        )

    def connect(self) -> int:
        """Start the arm if it does not move yet; return the number of the next state."""
        if math.isnan(self._started):
            self._started = clock.now()
            return 0
        return math.ceil(self.now() * self.rate)

    def now(self) -> float:
        """The arm's time [s]; 0 before the first connection."""
        if math.isnan(self._started):
            return 0.0
        return (clock.now() - self._started) * self.speed

    def due(self, number: int) -> float:
        """Time at which a state leaves the arm, by the host's monotonic clock [s]."""
        return self._started + number / (self.rate * self.speed)

    def shows(self, kind: str, moment: float) -> bool:
        """Return whether a kind of fault shows at a moment of the arm's time [s]."""
        return bool(self.faults) and any(
            fault.kind == kind and fault.affects(moment, self._random)
            for fault in self.faults
        )

    def state(self, moment: float) -> JointState:
        """Return what the arm sends at a moment of its time [s], with noise and faults."""
        if self._frozen is not None:
            if self.shows("freeze", moment):
                return replace(self._frozen, stamp=moment)
            self._frozen = None
        shows = partial(self.shows, moment=moment)
        position = self._noisy(self.motion.position(moment), self.noise)
        effort = None
        if self._effort is not None:
            effort = self._noisy(self._effort.position(moment), self.effort_noise)
            if shows("push"):
                effort = tuple([tau + 5 + self._random.gauss(0, 0.5) for tau in effort])
        if not self.faults:
            return JointState(stamp=moment, position=position, effort=effort)
        if shows("nan"):
            position = (*position[:-1], math.nan)
        elif shows("jump"):
            position = (*position[:-1], position[-1] + 0.2)
        elif shows("zeros"):
            position = (0.0,) * len(position)
        elif shows("short"):
            position = position[:-1]
        state = JointState(moment, position, effort)
        if shows("freeze"):
            self._frozen = state
        return state

    def _noisy(self, values: JointValues, sigma: float) -> JointValues:
        if sigma == 0:
            return values
        gauss = self._random.gauss
        return tuple([value + gauss(0.0, sigma) for value in values])
