"""Handling of keys: they act on the session, type in a line, answer, or finish with an outcome."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from ..session import Advice, Alarm, GuidanceClient, Recording, Session, SessionActions
from .key_bindings import ASKS, TypedLine
from .keyboard import TABLES

RESUME = (
    "GO ON?: is the base where it was?   "
    "{yes} yes, go on   {new} new placement   {finish} leave"
)
MOVED = "MOVED?: is the base elsewhere now, or will it be?   {yes} new placement   {new} go on"
"""Questions, each with its answers."""
WANTED = TABLES["wanted"]
"""Numbers that each action takes."""
DISTANCES = (0.01, 3.0)
"""Least and largest distance of sockets [m]."""


@dataclass(frozen=True)
class Outcome:
    """End of a session."""

    session: Session
    signal: int | None
    """The signal that ended it; None where the operator did."""
    refused: int
    """Number of refused captures."""
    successor: Recording | None = None
    """The next placement, open, if the operator goes on there."""
    advice: Advice | None = None
    """The last that was given."""


@dataclass
class KeyHandler:
    """Handler of one key after the other."""

    actions: SessionActions
    guidance: GuidanceClient
    capture: Callable[[], None]
    question: str = ""
    """Question that is open; a key is its answer."""
    hands_free: bool = False
    paused: bool = False
    """True while a key is awaited before anything is captured."""
    help: bool = False
    line: TypedLine | None = None
    """Line that is being typed."""

    def press(self, key: str) -> None:
        """Carry out a key; ``delete=12``, ``relabel=12:1``, ``measure=98.6`` are a script's."""
        word, _, numbers = key.partition("=")
        action = self.actions.session.keys.get(key)
        if word in ASKS and numbers:
            self._do(word, [float(number) for number in numbers.split(":")])
        elif line := self.line:
            finishes = key == "Enter" or action == "finish"
            self.line = None if finishes else line.with_key(key)
            if key == "Enter":
                self._do(line.action, line.numbers)
        elif self.question:
            self._answer(action)
        elif not self._cure(self.guidance.alarm, action):
            self.help = action == "help" and not self.help
            if key in "0123456789":
                self._switch(int(key))
            elif action in ASKS:
                self.line = TypedLine(action)
            elif action == "new":
                self.question = MOVED if self.actions.has_samples_before() else ""
            else:
                self._act(action)

    def _act(self, action: str | None) -> None:
        """Carry out an action that asks for nothing."""
        if action == "capture" and self.paused:
            self.paused = False
            if self.hands_free:
                self.actions.notify(
                    "captures by itself wherever the arm rests at a new pose"
                )
        elif action == "capture":
            self.capture()
        elif action == "undo":
            self.actions.undo()
        elif action == "redo":
            self.actions.redo()
        elif action == "avoid":
            advice = self.guidance.advice
            self.actions.avoid(advice.target if advice else None)
        elif action == "next":
            self._switch(self.actions.session.next_socket)
        elif action == "finish":
            self.finish()

    def finish(self) -> None:
        """End the session."""
        self.actions.session = replace(self.actions.session, finished=True)

    def _answer(self, action: str | None) -> None:
        """Take the answer to a question; any key but its own leaves it open."""
        if self.question == MOVED and action == "yes":
            self._start_new_placement()
        elif self.question == RESUME and action == "new":
            self._start_new_placement()
            return  # where that is refused, the base may be elsewhere still
        elif self.question == RESUME and action == "finish":
            self.finish()
        if action in ("yes", "new", "finish"):
            self.question = ""

    def _cure(self, alarm: Alarm | None, action: str | None) -> bool:
        """Carry out a key that answers an alarm; return False if it is none of those."""
        if not alarm:
            return False
        if action == "keep":
            self.actions.keep(alarm.text)
        elif action == "new" and alarm.samples:
            changed = alarm.cause in ("joint", "joints")
            if not self._start_new_placement(alarm.samples, readings_changed=changed):
                return True
        elif action == "delete" and alarm.cause in ("ball", "passing"):
            self.actions.doubt(alarm.samples)
        elif action == "measure" and alarm.cause == "distance":
            self.line = TypedLine("measure")
            return True
        elif action == "next" and alarm.cause == "socket":
            for number in alarm.samples:
                self.actions.relabel(number, alarm.socket)
            last = self.actions.session.last
            if last and last.number == alarm.samples[-1]:
                self._switch(alarm.socket)
        else:
            return False
        self.guidance.answered(alarm, keep=action == "keep")
        return True

    def _switch(self, socket: int) -> None:
        self.paused = False
        self.actions.switch(socket)

    def _start_new_placement(
        self, numbers: Sequence[int] = (), *, readings_changed: bool = False
    ) -> bool:
        """Go on at a new placement, with the samples since the first of some; False if refused."""
        begun = self.actions.begin_next(numbers, readings_changed=readings_changed)
        if begun:
            self.finish()
        return begun

    def _do(self, action: str, numbers: Sequence[float]) -> None:
        samples = [int(number) for number in numbers]
        lowest, highest = DISTANCES
        if action == "delete" and len(numbers) == 1:
            self.actions.delete(samples[0])
        elif action == "relabel" and len(numbers) == 2:
            self.actions.relabel(samples[0], samples[1])
        elif (
            action == "measure"
            and len(numbers) == 1
            and lowest <= numbers[0] / 1e3 <= highest
        ):
            # A further reading of the sockets' distance answers an alarm on it.
            alarm = self.guidance.alarm
            confirmed = self.actions.measured_again(numbers[0] / 1e3)
            if alarm and alarm.cause == "distance":
                self.guidance.answered(alarm, keep=confirmed)
        else:
            self.actions.alarm(f"{action}: type {WANTED[action]}")
