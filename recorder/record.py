"""The recorder: one loop that joins states, keys, session, file and screen."""

import signal
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace

from ..drivers import clock
from .csv_files import RecordingError
from .display import Display
from .keyboard import HangUp, Keyboard
from .push import Push
from .recording import Recording
from .rest import Rest
from .samples import Sample
from .screen import View
from .script import Script
from .session import Session
from .signals import Signals
from .stream import Stream
from .watch import SILENT, Watch

__all__ = ["Outcome", "Recorder"]

FRAME = 1 / 15
"""Time between two drawings of the screen [s]."""
MOST_STATES = 500
"""How many states are looked at in one go, so that keys and the screen need not wait for more."""


@dataclass(frozen=True)
class Outcome:
    """How a session ended."""

    session: Session
    signal: int | None
    """The signal that ended it; None where the operator did."""
    refused: int
    """How many captures were refused."""


@dataclass
class Recorder:
    """One session at the robot: :meth:`run` it.

    A capture is on the disk before the session counts it, and so before the screen shows it.
    """

    session: Session
    stream: Stream
    watch: Watch
    recording: Recording
    display: Display
    title: str = ""
    keyboard: Keyboard | None = None
    script: Script | None = None
    push: Push | None = None
    check: Callable[[Sequence[Sample]], str | None] | None = None
    """Says what is odd about the last of some samples by the model; None if nothing is."""

    def __post_init__(self) -> None:
        self._push = self.push or Push(self.session.joints)
        self._refused = 0
        self._help = False
        self._pushed: str | None = None
        self._silent_since: float | None = None
        self._refused_at: Rest | None = None
        self._started = clock.now()
        self._next_frame = 0.0

    def run(self) -> Outcome:
        """Record until the operator finishes, a signal comes, or the terminal is gone.

        Raises:
            ScriptError: The key script is wrong, or waits for what does not come.
        """
        with Signals() as signals:  # first, so that no signal leaves the terminal as it is now
            try:
                with self.display, self.keyboard or nullcontext():
                    while not self.session.finished and signals.received is None:
                        self._wait(signals)
                        self._take_states()
                        self._follow_stream()
                        self._draw()
            except HangUp:
                return Outcome(self.session, signals.received or signal.SIGHUP, self._refused)
            return Outcome(self.session, signals.received, self._refused)

    # -- what comes in ---------------------------------------------------------------------------

    def _wait(self, signals: Signals) -> None:
        """Wait for a key, a signal, or the time to draw; read what there is."""
        sources: list[Signals | Keyboard | Script] = [signals]
        if self.keyboard:
            sources.append(self.keyboard)
        if self.script and self.script.hungry:
            sources.append(self.script)
        behind = self.stream.waiting > MOST_STATES
        pause = 0.0 if behind else max(0.0, self._next_frame - clock.now())
        ready = clock.wait(sources, pause)
        if signals in ready:
            signals.read()
        if self.script and self.script in ready:
            self.script.read()
        if self.keyboard and self.keyboard in ready:
            keys = self.keyboard.read()
            self._take_states()  # what came before the key was pressed
            for key in keys:
                if not self.session.finished:
                    self._press(key, clock.now())
            self._next_frame = 0.0

    def _take_states(self) -> None:
        """Look at the states that have come, in order, the oldest first."""
        for arrival, state, connection in self.stream.take(MOST_STATES):
            looked = self.watch.feed(state, arrival, connection)
            if looked and self.script:
                self._follow_script(self.script, arrival)
            if self.session.finished:
                return
        if self.script:
            self._follow_script(self.script, clock.now())

    def _trouble(self, now: float) -> str | None:
        """Say why nothing may be captured now; None if it may."""
        if self.stream.trouble and self.watch.age(now) > SILENT:
            return f"the stream is silent: {self.stream.trouble}"
        return self.watch.trouble(now)

    def _follow_stream(self) -> None:
        """Say when the stream falls silent, and when it is back."""
        now = clock.now()
        silent = now - max(self.stream.arrival, self._started) > SILENT
        if silent and self._silent_since is None:
            self._silent_since = now
            self._alarm(self._trouble(now) or "the stream is silent")
        elif not silent and self._silent_since is not None:
            self._tell(f"the stream is back after {now - self._silent_since:.1f} s")
            self._silent_since = None
        self._pushed = self._push.look(self.watch.rest) if self.watch.rest else None

    # -- keys ------------------------------------------------------------------------------------

    def _press(self, key: str, now: float) -> None:
        key = key.lower()
        self._help = key == "?" and not self._help
        if key in (" ", "a"):
            self._capture(now)
        elif key in ("d", "u"):
            self._undo()
        elif key == "s":
            self._switch((self.session.socket + 1) % self.session.sockets)
        elif key in "0123456789":
            self._switch(int(key))
        elif key == "q":
            self.session = replace(self.session, finished=True)

    def _capture(self, now: float) -> None:
        rest = self.watch.rest
        reason = self._trouble(now)
        if rest and not reason:
            reason = self.session.refusal(rest.position)
        if not rest or reason:
            self._refuse(reason or "still moving")
            return
        sample = Sample(
            position=rest.position,
            socket=self.session.socket,
            effort=rest.effort,
            number=self.session.next_number,
            time=time.time(),
            stamp=rest.stamp,
            states=rest.states,
            spread=rest.spread,
        )
        try:
            self.recording.capture(sample)
        except RecordingError as error:
            self._refuse(str(error))
            return
        self.session = self.session.captured(sample)
        self._pushed = self._push.look(rest)
        self._say_captured(sample)

    def _say_captured(self, sample: Sample) -> None:
        count = self.session.counts[sample.socket]
        said = f"captured sample {sample.number}: {count} in socket {sample.socket}"
        if self._pushed:
            said += f", while the arm was pushed ({self._pushed})"
        if count == self.session.target:
            said += "; that is the target: s for the next socket, q to finish"
        self._tell(said)
        doubt = self.check and self.check(self.session.live)
        if doubt:
            self._alarm(doubt)

    def _refuse(self, reason: str) -> None:
        self._refused += 1
        self._refused_at = self.watch.rest
        self._alarm(f"refused: {reason}")

    def _undo(self) -> None:
        last = self.session.last
        if last is None:
            self._alarm("nothing to undo")
            return
        try:
            self.recording.undo(last, time.time())
        except RecordingError as error:
            self._alarm(f"not undone: {error}")
            return
        self.session = self.session.undone()
        self._tell(f"took back sample {last.number} of socket {last.socket}")

    def _switch(self, socket: int) -> None:
        if socket >= self.session.sockets:
            self._alarm(f"there is no socket {socket}: they are 0 to {self.session.sockets - 1}")
            return
        self.session = self.session.switched(socket)
        self._tell(f"socket {socket} is active: put the ball there")

    # -- keys from a script ----------------------------------------------------------------------

    def _follow_script(self, script: Script, now: float) -> None:
        """Press all keys of the script that are due."""
        stamp = self.watch.latest.stamp if self.watch.latest else 0.0
        while not self.session.finished:
            key = script.due(now, stamp, self._no_new_rest(now))
            if key is None:
                break
            self._press(key, now)
        if script.over:
            self.session = replace(self.session, finished=True)

    def _no_new_rest(self, now: float) -> str | None:
        """Say why the arm does not rest where a script may capture; None if it does."""
        rest = self.watch.rest
        trouble = self._trouble(now)
        if trouble or not (rest and self.watch.settled):
            return trouble or "not yet still for long enough"
        if self._refused_at and self.session.same(self._refused_at.position, rest.position):
            return "it rests where a capture was just refused"
        earlier = self.session.nearest(rest.position)
        return earlier and f"it rests where sample {earlier.number} was taken"

    # -- what goes out ---------------------------------------------------------------------------

    def _tell(self, text: str) -> None:
        self.session = self.session.with_message(text)

    def _alarm(self, text: str) -> None:
        self.session = self.session.with_message(text, alarm=True)
        self.display.bell()

    def _draw(self) -> None:
        now = clock.now()
        if now < self._next_frame and not self.session.finished:
            return
        self._next_frame = now + FRAME
        latest = self.watch.latest
        self.display.show(
            View(
                session=self.session,
                title=self.title,
                position=latest.position if latest else None,
                trouble=self._trouble(now),
                push=self._pushed,
                rate=self.watch.rate(now),
                age=self.watch.age(now),
                missed=self.stream.missed,
                drops=self.stream.drops,
                discarded=self.stream.rejected,
                help=self._help,
                scripted=self.script is not None,
            )
        )
