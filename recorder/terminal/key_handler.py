"""Handling of keys: they act on the session, open a line to type in, answer, or finish."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ..session import Alarm, GuidanceClient, SessionActions
from .key_bindings import ASKS, TypedLine

RESUME = "GO ON?: is the base where it was?   y yes, go on   n new placement   q leave"
MOVED = "MOVED?: is the base elsewhere now, or will it be?   y new placement   n go on"
"""Questions, each with its answers."""
WANTED = {
    "delete": "a sample's number",
    "relabel": "a sample's number, and a socket",
    "measure": "the distance of the sockets' centres in mm, as in 100.08",
}
"""Numbers that each action takes."""
DISTANCES = (0.01, 3.0)
"""Least and largest distance of sockets [m]."""


class KeyHandler:
    """Handler of one key after the other."""

    def __init__(
        self,
        actions: SessionActions,
        keys: Mapping[str, str],
        guidance: GuidanceClient,
        capture: Callable[[], None],
        *,
        question: str = "",
        hands_free: bool = False,
        paused: bool = False,
    ) -> None:
        self.help = False
        self.line: TypedLine | None = None
        self.question, self.paused = question, paused
        self.new_placement = False
        """True if the operator goes on at a new placement."""
        self.readings_changed = False
        """True if joints read otherwise since: earlier placements tell nothing of the new one."""
        self._hands_free = hands_free
        self._actions = actions
        self._keys = keys
        self._guidance = guidance
        self._capture = capture
        self._by_name: dict[str, Callable[[], None]] = {
            "capture": self._go_on_or_capture,
            "undo": actions.undo,
            "redo": actions.redo,
            "next": lambda: self._switch(actions.session.next_socket),
            "finish": self.finish,
        }

    def press(self, key: str) -> None:
        """Carry out a key; ``delete=12``, ``relabel=12:1``, ``measure=98.6`` are a script's."""
        word, _, numbers = key.partition("=")
        action = self._keys.get(key)
        if word in ASKS and numbers:
            self._do(word, [float(number) for number in numbers.split(":")])
        elif self.line:
            self._type_on(self.line, key)
        elif self.question:
            self._answer(action)
        elif not self._cure(self._guidance.alarm, action):
            self.help = action == "help" and not self.help
            if key in "0123456789":
                self._switch(int(key))
            elif action in ASKS:
                self.line = TypedLine(action)
            elif action == "new":
                self.question = MOVED
            elif action in self._by_name:
                self._by_name[action]()

    def finish(self) -> None:
        """End the session."""
        self._actions.session = replace(self._actions.session, finished=True)

    def _answer(self, action: str | None) -> None:
        """Take the answer to a question; any key but its own leaves it open."""
        new = "yes" if self.question == MOVED else "new"
        if action == new:
            self._start_new_placement()
        elif action == "finish" and self.question == RESUME:
            self.finish()
        elif action in ("yes", "new", "finish"):
            self.question = ""

    def _cure(self, alarm: Alarm | None, action: str | None) -> bool:
        """Carry out a key that answers an alarm; return False if it is none of those."""
        if alarm is None:
            return False
        if action == "keep":
            self._actions.keep(alarm.text)
        elif action == "new" and alarm.samples:
            self.readings_changed = alarm.cause == "joints"
            self._start_new_placement(alarm.samples)
        elif action == "delete" and alarm.cause == "ball":
            self._actions.doubt(alarm.samples)
        elif action == "measure" and alarm.cause == "distance":
            self.line = TypedLine("measure")
            return True
        elif action == "next" and alarm.cause == "socket":
            for number in alarm.samples:
                self._actions.relabel(number, alarm.socket)
            last = self._actions.session.last
            if last and last.number == alarm.samples[-1]:
                self._switch(alarm.socket)
        else:
            return False
        self._guidance.answered(alarm, keep=action == "keep")
        return True

    def _go_on_or_capture(self) -> None:
        if self.paused:
            self.paused = False
            if self._hands_free:
                self._actions.notify("captures by itself wherever the arm rests at a new pose")
        else:
            self._capture()

    def _switch(self, socket: int) -> None:
        self.paused = False
        self._actions.switch(socket)

    def _start_new_placement(self, numbers: Sequence[int] = ()) -> None:
        """Go on at a new placement, with the samples since the first of some, if any."""
        if not numbers or self._actions.move_on(numbers):
            self.new_placement = True
            self.finish()

    def _type_on(self, line: TypedLine, key: str) -> None:
        self.line = line.with_key(key)
        if key == "Enter":
            self.line = None
            self._do(line.action, line.numbers)
        elif self._keys.get(key) == "finish":
            self.line = None

    def _do(self, action: str, numbers: Sequence[float]) -> None:
        samples = [int(number) for number in numbers]
        if action == "delete" and len(numbers) == 1:
            self._actions.delete(samples[0])
        elif action == "relabel" and len(numbers) == 2:
            self._actions.relabel(samples[0], samples[1])
        elif action == "measure" and len(numbers) == 1:
            self._measure(numbers[0] / 1e3)
        else:
            self._actions.alarm(f"{action}: type {WANTED[action]}")

    def _measure(self, distance: float) -> None:
        """Take a further reading of the sockets' distance [m], which answers an alarm on it."""
        lowest, highest = DISTANCES
        if not lowest <= distance <= highest:
            self._actions.alarm(f"measure: type {WANTED['measure']}")
            return
        alarm = self._guidance.alarm
        confirmed = self._actions.measured_again(distance)
        if alarm and alarm.cause == "distance":
            self._guidance.answered(alarm, keep=confirmed)
