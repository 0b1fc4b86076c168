"""What the keys do: they work on the desk, open a line to type in, answer a question, or finish."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from ..session import SessionActions
from .key_bindings import Prompt


class Controls:
    """Takes one key after the other.

    Args:
        desk: What the keys work on.
        keys: What each does.
        capture: Captures now, or says why not.
        asking: Whether the operator is asked first about what is continued.
        hands_free: Whether there is capturing without a key.
        paused: Whether a key is waited for before anything is captured.
    """

    def __init__(
        self,
        desk: SessionActions,
        keys: Mapping[str, str],
        capture: Callable[[], None],
        *,
        asking: bool = False,
        hands_free: bool = False,
        paused: bool = False,
    ) -> None:
        self.help = False
        self.prompt: Prompt | None = None
        self.asking, self.paused = asking, paused
        self.elsewhere = False
        """Whether the operator goes on at a new placement."""
        self._hands_free = hands_free
        self._desk = desk
        self._keys = keys
        self._capture = capture
        self._acts: dict[str, Callable[[], None]] = {
            "capture": self._go_on_or_capture,
            "undo": desk.undo,
            "redo": desk.redo,
            "delete": lambda: self._type("delete"),
            "relabel": lambda: self._type("relabel"),
            "next": lambda: self._switch(desk.session.next_socket),
            "finish": self.finish,
            "new": self._new_placement,
        }

    def press(self, key: str) -> None:
        """Do what a key stands for; ``delete=12`` and ``relabel=12:1`` are words of a script."""
        word, _, numbers = key.partition("=")
        if word in ("delete", "relabel") and numbers:
            self._do(word, [int(number) for number in numbers.split(":")])
        elif self.prompt:
            self._type_on(self.prompt, key)
        elif self.asking:
            self._answer(self._keys.get(key))
        else:
            action = self._keys.get(key)
            self.help = action == "help" and not self.help
            if key in "0123456789":
                self._switch(int(key))
            elif action in self._acts:
                self._acts[action]()

    def finish(self) -> None:
        """End the session."""
        self._desk.session = replace(self._desk.session, finished=True)

    def _answer(self, action: str | None) -> None:
        """Take the answer to what is continued."""
        if action == "new":
            self.elsewhere = True
            self.finish()
        elif action == "finish":
            self.finish()
        self.asking = action != "yes"

    def _go_on_or_capture(self) -> None:
        if self.paused:
            self.paused = False
            if self._hands_free:
                self._desk.tell("captures by itself wherever the arm rests at a new pose")
        else:
            self._capture()

    def _switch(self, socket: int) -> None:
        self.paused = False
        self._desk.switch(socket)

    def _new_placement(self) -> None:
        """Go on at a new placement, if the last sample was found to be of another one."""
        if not self._desk.doubted:
            self._desk.alarm("q finishes; n is for a base that moved, once a sample shows it")
            return
        self._desk.undo()
        self.elsewhere = True
        self.finish()

    def _type(self, action: str) -> None:
        self.prompt = Prompt(action)

    def _type_on(self, prompt: Prompt, key: str) -> None:
        self.prompt = prompt.with_key(key)
        if key == "Enter":
            self.prompt = None
            self._do(prompt.action, prompt.numbers)
        elif self._keys.get(key) == "finish":
            self.prompt = None

    def _do(self, action: str, numbers: list[int]) -> None:
        if action == "delete" and len(numbers) == 1:
            self._desk.delete(numbers[0])
        elif action == "relabel" and len(numbers) == 2:
            self._desk.relabel(numbers[0], numbers[1])
        else:
            wanted = "a sample's number" + (", and a socket" if action == "relabel" else "")
            self._desk.alarm(f"{action}: type {wanted}")
