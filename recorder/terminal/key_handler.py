"""Handling of keys: they act on the session, open a line to type in, answer, or finish."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from ..session import SessionActions
from .key_bindings import TypedLine


class KeyHandler:
    """Handler of one key after the other.

    Args:
        actions: On the session.
        keys: Action of each key.
        capture: Captures now, or tells why not.
        asking: True to ask first about the recording that is continued.
        hands_free: True where there is capturing without a key.
        paused: True to await a key before anything is captured.
    """

    def __init__(
        self,
        actions: SessionActions,
        keys: Mapping[str, str],
        capture: Callable[[], None],
        *,
        asking: bool = False,
        hands_free: bool = False,
        paused: bool = False,
    ) -> None:
        self.help = False
        self.line: TypedLine | None = None
        self.asking, self.paused = asking, paused
        self.new_placement = False
        """True if the operator goes on at a new placement."""
        self._hands_free = hands_free
        self._actions = actions
        self._keys = keys
        self._capture = capture
        self._by_name: dict[str, Callable[[], None]] = {
            "capture": self._go_on_or_capture,
            "undo": actions.undo,
            "redo": actions.redo,
            "delete": lambda: self._type("delete"),
            "relabel": lambda: self._type("relabel"),
            "next": lambda: self._switch(actions.session.next_socket),
            "finish": self.finish,
            "new": self._start_new_placement,
        }

    def press(self, key: str) -> None:
        """Carry out a key; ``delete=12`` and ``relabel=12:1`` are words of a script."""
        word, _, numbers = key.partition("=")
        if word in ("delete", "relabel") and numbers:
            self._do(word, [int(number) for number in numbers.split(":")])
        elif self.line:
            self._type_on(self.line, key)
        elif self.asking:
            self._answer(self._keys.get(key))
        else:
            action = self._keys.get(key)
            self.help = action == "help" and not self.help
            if key in "0123456789":
                self._switch(int(key))
            elif action in self._by_name:
                self._by_name[action]()

    def finish(self) -> None:
        """End the session."""
        self._actions.session = replace(self._actions.session, finished=True)

    def _answer(self, action: str | None) -> None:
        """Take the answer to the question whether to go on."""
        if action == "new":
            self.new_placement = True
            self.finish()
        elif action == "finish":
            self.finish()
        self.asking = action != "yes"

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

    def _start_new_placement(self) -> None:
        """Go on at a new placement, if the last sample was found to be of another one."""
        if not self._actions.suspect:
            self._actions.alarm("q finishes; n is for a base that moved, once a sample shows it")
            return
        self._actions.undo()
        self.new_placement = True
        self.finish()

    def _type(self, action: str) -> None:
        self.line = TypedLine(action)

    def _type_on(self, line: TypedLine, key: str) -> None:
        self.line = line.with_key(key)
        if key == "Enter":
            self.line = None
            self._do(line.action, line.numbers)
        elif self._keys.get(key) == "finish":
            self.line = None

    def _do(self, action: str, numbers: list[int]) -> None:
        if action == "delete" and len(numbers) == 1:
            self._actions.delete(numbers[0])
        elif action == "relabel" and len(numbers) == 2:
            self._actions.relabel(numbers[0], numbers[1])
        else:
            wanted = "a sample's number" + (", and a socket" if action == "relabel" else "")
            self._actions.alarm(f"{action}: type {wanted}")
