"""A recording session as an immutable value: samples, active socket, messages.

Each event returns a new one, as in ``session = session.captured(sample)``.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import takewhile

from .. import SOCKETS, Configuration, Sample
from ..stream import JointLimits, StationaryPose
from .key_names import KEYS, key_names, with_key_names

Numbers = tuple[int, ...]
"""Numbers of samples."""
TARGET = 30
"""Default number of samples for each socket."""
USUAL = "12-20"
"""Samples of each socket with which a guided session usually ends."""
BLOCK = 6
"""Samples after which it is the next socket's turn: in the order 0 1 0 1 a base that moved, or a
ball in the wrong socket, is told from a wrong distance of the sockets."""
SAME = math.radians(1.0)
"""Largest difference at every joint between configurations that are nearly the same [rad]."""
SAME_LENGTH = 2e-3
"""The same for a prismatic joint [m]."""
STOOD_STILL = math.radians(0.2)
"""An arm within this of a configuration in another socket still stands in that socket [rad]."""
BEYOND_LIMITS = math.radians(3.0)
"""Tolerance of the joints' limits [rad]; sensors and models disagree a little."""
BEYOND_LIMITS_LENGTH = 5e-3
"""The same for a prismatic joint [m]."""


@dataclass(frozen=True, slots=True)
class Message:
    """One line to the operator."""

    text: str
    alarm: bool = False
    """Something was refused, or needs attention."""


@dataclass(frozen=True)
class Session:
    """Everything that happened at one placement so far."""

    joints: tuple[JointLimits, ...]
    sockets: int = SOCKETS
    target: int = TARGET
    """Number of samples for each socket."""
    socket: int = 0
    """The active socket."""
    samples: tuple[Sample, ...] = ()
    """All captures in order, also those that were taken back."""
    withdrawn: Numbers = ()
    """Numbers of the samples that were taken back, the last one at the end."""
    doubted: Numbers = ()
    """Numbers of those that were taken back because of an alarm."""
    avoided: tuple[Configuration, ...] = ()
    """Proposed poses that the operator says cannot be taken here [rad], [m]."""
    reconnected: Numbers = ()
    """Numbers of the samples before which the connection was lost, and came back."""
    distance: float | None = None
    """Distance of the sockets, by the last reading [m]; None where nobody said it."""
    measured: bool = True
    """True where somebody measured that distance, without which `solve` gives no PASS."""
    block: int | None = None
    """Samples in a row after which it is the next socket's turn; None without turns."""
    similar_models: Callable[[Sequence[float]], str | None] | None = None
    """Names other robots that may be at a configuration where this one cannot."""
    keys: Mapping[str, str] = field(default_factory=lambda: KEYS)
    """Action of each key."""
    messages: tuple[Message, ...] = ()
    finished: bool = False

    @cached_property
    def live(self) -> tuple[Sample, ...]:
        """The samples that count: all but those that were taken back."""
        return tuple(s for s in self.samples if s.number not in self.withdrawn)

    @cached_property
    def counts(self) -> Numbers:
        """Number of samples in each socket, without those that were taken back."""
        counts = Counter(sample.socket for sample in self.live)
        return tuple(counts[socket] for socket in range(self.sockets))

    @property
    def doubted_run(self) -> tuple[Sample, ...]:
        """Samples that alarms took back since the last but one that counts."""
        first = self.live[-2].number if len(self.live) > 1 else 0
        numbers = {n for n in self.doubted if n in self.withdrawn and n > first}
        return tuple(sample for sample in self.samples if sample.number in numbers)

    @property
    def span(self) -> float:
        """The most that any joint turned from sample to sample [rad], [m] where it is prismatic."""
        joints = zip(*(sample.position for sample in self.live), strict=True)
        return max((max(q) - min(q) for q in joints), default=0.0)

    @property
    def turn_done(self) -> bool:
        """True once the active socket has had its turn."""
        last_first = reversed(self.live)
        run = list(takewhile(lambda sample: sample.socket == self.socket, last_first))
        return self.block is not None and self.sockets > 1 and len(run) >= self.block

    @property
    def next_socket(self) -> int:
        """The socket to go on with: after the active one, the first that lacks samples."""
        sockets = [(self.socket + i) % self.sockets for i in range(1, self.sockets)]
        lacking = [k for k in sockets if self.counts[k] < self.target]
        return (lacking or sockets or [self.socket])[0]

    @property
    def asked(self) -> str:
        """Samples that each socket is to have, in words."""
        return USUAL if self.block else str(self.target)

    @property
    def complete(self) -> bool:
        """True once every socket has its target."""
        return min(self.counts) >= self.target

    @property
    def next_number(self) -> int:
        """The number of the next capture."""
        return len(self.samples) + 1

    @property
    def last(self) -> Sample | None:
        """The sample that undo takes back."""
        return self.live[-1] if self.live else None

    def sample_at(self, pose: StationaryPose, time: float | None = None) -> Sample:
        """Return what the next capture is, where the arm rests now; the time is the computer's."""
        return Sample(
            position=pose.position,
            socket=self.socket,
            effort=pose.effort,
            number=self.next_number,
            time=time,
            stamp=pose.stamp,
            states=pose.states,
            spread=pose.spread,
        )

    def captured(self, sample: Sample) -> "Session":
        """Return the session with one more sample."""
        return replace(self, samples=(*self.samples, sample))

    def without(self, number: int) -> "Session":
        """Return the session with a sample taken back."""
        return replace(self, withdrawn=(*self.withdrawn, number))

    def switched(self, socket: int) -> "Session":
        """Return the session with another socket active."""
        return replace(self, socket=socket)

    def with_message(self, text: str, *, alarm: bool = False) -> "Session":
        """Return the session with one more message, which names keys as the operator has them."""
        message = Message(self.with_keys(text), alarm)
        return replace(self, messages=(*self.messages[-99:], message))

    @cached_property
    def key_names(self) -> dict[str, str]:
        """The key of each action that texts name."""
        return key_names(self.keys)

    def with_keys(self, text: str) -> str:
        """Return a text with keys in the place of actions in braces, as ``{finish}``."""
        return with_key_names(text, self.key_names)

    def refusal(self, position: Sequence[float]) -> str | None:
        """Return the reason to refuse a configuration at the active socket; None without one."""
        for joint, value in zip(self.joints, position, strict=True):
            margin = BEYOND_LIMITS_LENGTH if joint.prismatic else BEYOND_LIMITS
            if not joint.allows(value, margin):
                arm = self.similar_models and self.similar_models(position)
                hint = f" This moves like a {arm}." if arm else ""
                sign = " and sign" if joint.allows(-value, 0.0) else ""
                return (
                    f"{joint.name} reads {joint.shown(value)}, outside its limits "
                    f"{joint.shown(joint.lower)} to {joint.shown(joint.upper)}: "
                    f"is this the right robot model{sign}?{hint}"
                )
        return self.repeated(position) or self.left_behind(position)

    def repeated(self, position: Sequence[float]) -> str | None:
        """Return the refusal of a configuration that the active socket has already, or None."""
        for sample in self.live:
            if sample.socket == self.socket and self.same(sample.position, position):
                return f"nearly the same configuration as sample {sample.number}: move the arm on"
        return None

    def left_behind(self, position: Sequence[float]) -> str | None:
        """Return the refusal of a pose in which the ball is still in another socket, or None."""
        for sample in self.live:
            stands = self.same(sample.position, position, STOOD_STILL)
            if stands and sample.socket != self.socket:
                return (
                    f"the arm stands where it stood for sample {sample.number} in socket "
                    f"{sample.socket}: move the ball to socket {self.socket} first"
                )
        return None

    def same(
        self, a: Sequence[float], b: Sequence[float], within: float = SAME
    ) -> bool:
        """Return whether two configurations differ by at most an angle [rad] at every joint."""
        length = SAME_LENGTH * within / SAME
        return all(
            abs(joint.difference(x - y)) <= (length if joint.prismatic else within)
            for joint, x, y in zip(self.joints, a, b, strict=True)
        )
