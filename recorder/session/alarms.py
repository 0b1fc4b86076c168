"""Alarms: faults that the samples show, keys that cure them, answers; and alerts to a stream."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from ...drivers import clock
from ...errors import read_json
from .. import Configuration, Sample
from ..stream import Stream, StreamMonitor
from .actions import SessionActions

Cause = Literal[
    "base",
    "again",
    "passing",
    "ball",
    "flange",
    "socket",
    "distance",
    "joint",
    "joints",
    "model",
    "other",
]
NEAR = 2
"""Samples by which the begin of one fault may be told differently as more are recorded."""
SLIPS = "JOINT SLIPS"
"""Words for a joint whose readings change again and again."""
DRIFTS = "DRIFTS"
"""Words for a base that creeps: later samples show more of one drift."""
ANOTHER_ARM = "ANOTHER ARM?"
"""Words for a fault that began as the connection came back."""
CURES: dict[Cause, dict[str, str]] = read_json(Path(__file__).with_name("cures.json"))
"""Actions that cure each kind of cause, each with what it does; the likeliest cure first."""


@dataclass(frozen=True)
class Alarm:
    """A fault that the samples show."""

    cause: Cause
    words: str
    """It in a word or two."""
    text: str
    """It in a line, with the sample since which it holds."""
    samples: tuple[int, ...] = ()
    """Numbers of the samples that it concerns; none where it concerns all."""
    socket: int = 0
    """The one in which the ball truly was."""
    stays: bool = True
    """True if samples stay where they are when those of the alarm go into a new placement."""

    @property
    def answers(self) -> dict[str, str]:
        """Actions that answer it, each with what it does, the likeliest cure first."""
        cures = {**CURES[self.cause], "keep": "keep"}
        return {a: text for a, text in cures.items() if self.stays or a != "new"}

    @property
    def reason(self) -> str:
        """The line, with the keys that answer it."""
        answers = (f"{{{action}}} {text}" for action, text in self.answers.items())
        mark = "" if self.text.endswith("?") else ":"
        return f"{self.text}{mark} {', '.join(answers)}"

    def is_like(self, alarm: "Alarm") -> bool:
        """Return whether two alarms tell of one fault, which further samples locate better."""
        first, second = (*self.samples, 0)[0], (*alarm.samples, 0)[0]
        return self.cause == alarm.cause and abs(first - second) <= NEAR

    def covers(self, alarm: "Alarm") -> bool:
        """Return whether an alarm tells nothing new to whoever keeps this fault."""
        if self.words == SLIPS:
            return alarm.cause not in ("socket", "distance")
        if self.words == ANOTHER_ARM:
            alarm = alarm.after_reconnection()
        creeps = alarm.cause in ("base", "again") or alarm.words == DRIFTS
        return self.is_like(alarm) or (self.words == DRIFTS and creeps)

    def after_reconnection(self) -> "Alarm":
        """Return it as it is told where no sound sample came since the connection was lost."""
        text = f"{self.text}, as the connection came back"
        if self.cause not in ("base", "flange", "joint", "joints", "other"):
            return replace(self, text=text)
        text = f"another arm, or its zeros: {text}"
        return replace(self, cause="joints", words=ANOTHER_ARM, text=text)


Alarms = tuple[Alarm, ...]


@dataclass(frozen=True)
class Answers:
    """The operator's answers to alarms."""

    kept: Alarms = ()
    """Alarms whose samples are kept as they are."""
    doubted: tuple[Sample, ...] = ()
    """The last samples, as far as alarms took them back; what they have in common is evidence."""
    distance: float | None = None
    """Distance of the sockets, by the last reading [m]; None where nobody said it."""
    avoided: tuple[Configuration, ...] = ()
    """Proposed poses that cannot be taken here."""
    followed: tuple[Configuration, ...] = ()
    """Proposed poses near which a sample was taken. Where the ball is mounted otherwise than in
    the model, the hand that followed one ended beside it."""
    confined: bool = False
    """True once several proposals in a row were not followed: the arm may not get farther."""

    def open_alarms(self, alarms: Iterable[Alarm]) -> Alarms:
        """Return the alarms that are not answered."""
        return tuple(
            alarm
            for alarm in alarms
            if not any(kept.covers(alarm) for kept in self.kept)
        )


NO_ANSWERS = Answers()


class StreamAlerts:
    """Alerts on a stream, one for each kind of trouble."""

    def __init__(
        self, stream: Stream, monitor: StreamMonitor, actions: SessionActions
    ) -> None:
        self._stream, self._monitor, self._actions = stream, monitor, actions
        self._started = clock.now()
        self._silent_since: float | None = None
        self._drops = stream.drops
        self._alarmed = set[str]()
        self._log_alarmed = False

    def trouble(self, now: float) -> str | None:
        """Return the reason why the stream cannot be trusted now; None if it can."""
        if self._stream.trouble and self._monitor.age(now) > self._monitor.patience:
            return f"the stream is silent: {self._stream.trouble}"
        return self._monitor.unsound(now)

    def update(self, now: float) -> None:
        """Alert to changes."""
        log = self._stream.log
        if log and log.trouble and not self._log_alarmed:
            self._log_alarmed = True
            self._actions.alarm(log.trouble)
        if self._stream.drops > self._drops:
            self._drops = self._stream.drops
            self._actions.reconnected()
        silent = now - max(self._stream.arrival, self._started) > self._monitor.patience
        trouble = self.trouble(now)
        if not silent and self._silent_since is not None:
            silence = now - self._silent_since
            self._actions.notify(f"the stream is back after {silence:.1f} s")
            self._silent_since = None
            self._alarmed.clear()
        elif silent and self._silent_since is None:
            self._silent_since = now
            self._alarm(trouble or "the stream is silent")
        elif trouble is None:
            self._alarmed.clear()
        elif silent or math.isfinite(self._monitor.age(now)):
            self._alarm(trouble)

    def _alarm(self, trouble: str) -> None:
        kind = re.sub(r"[\d.]+", "", trouble)
        if kind not in self._alarmed:  # two that take turns are told once
            self._alarmed.add(kind)
            self._actions.alarm(trouble)
