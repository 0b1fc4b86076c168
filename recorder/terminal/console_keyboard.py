"""Single key presses from a console of Windows, by the contract of :class:`.keyboard.Keyboard`."""

import socket
from typing import Protocol

from ...drivers import clock
from .keyboard import Keyboard

POLL_SECONDS = 0.01
_KEYPAD = ("[A", "[B", "[D", "[C", "[H", "[F", "[2~", "[3~", "[5~", "[6~")
_FUNCTION = ("OP", "OQ", "OR", "OS", "[15~", "[17~", "[18~", "[19~", "[20~", "[21~", "[23~")
_SEQUENCES = {
    **dict(zip("HPKMGORSIQ", _KEYPAD, strict=True)),
    **dict(zip(";<=>?@ABCD\x85", _FUNCTION, strict=True)),
}
"""What follows ESC, by the second character of a special key."""


class Console(Protocol):
    """The part of the module msvcrt that is used."""

    def kbhit(self) -> bool:
        """Return whether a key waits."""
        ...

    def getwch(self) -> str:
        """Return the next character; a special key is two."""
        ...


class ConsoleKeyboard(Keyboard):
    """Reads keys without waiting for Enter, and without showing them.

    Args:
        console: The module msvcrt.
    """

    def __init__(self, console: Console) -> None:
        self._console = console
        self._reader, self._writer = socket.socketpair()
        super().__init__(self._reader.fileno())

    def __enter__(self) -> "Keyboard":
        self._stop = clock.repeat(self._pass_on, self._writer.close)
        return self

    def __exit__(self, *_: object) -> None:
        self._stop()
        self._reader.close()

    def _received(self) -> bytes:
        return self._reader.recv(1024)

    def _pass_on(self) -> bool:
        clock.sleep(POLL_SECONDS)
        while self._console.kbhit():
            key = self._console.getwch()
            if key in "\0\xe0":
                key = "\x1b" + _SEQUENCES.get(self._console.getwch(), "[~")
            self._writer.send(key.encode())
        return True
