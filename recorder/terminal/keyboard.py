"""Single key presses and signals of a terminal, which is given back as it was whatever happens."""

import json
import os
import re
import signal
import socket
import sys
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any

from ...drivers import clock

# Arrow keys, function keys, Alt with a letter: none of them may pass for a letter.
_KEY = re.compile(rb"\x1b(\[\[?[0-?]*[ -/]*[@-~]|O[ -~]|[^\[O\x1b])|[^\x1b]|\x1b")
_FILE = Path(__file__).with_name("keys.json")
TABLES: dict[str, dict[str, str]] = json.loads(_FILE.read_text())
_SEQUENCES = TABLES["of_sequences"]
"""Key by the sequence that follows ``ESC [`` or ``ESC O``."""
_SINGLE = TABLES["of_characters"]
"""Key by the one character that it sends."""
_SPECIAL = TABLES["of_console"]
"""Rest of a special key after ESC, by its second character in a console."""
NAMES = frozenset({*_SEQUENCES.values(), *_SINGLE.values(), "space"})
"""Names of the keys that are no printable character."""
_UNFINISHED = re.compile(rb"\x1b(\[[0-?]*[ -/]*|O)?$")
_ESCAPE_TIME = 0.1
"""The rest of an escape sequence follows within this time [s]."""

POLL_SECONDS = 0.01


class HangUp(Exception):  # noqa: N818 - an event, not a fault
    """The terminal is gone."""


class Keyboard:
    """Reads keys of a terminal without waiting for Enter, and without showing them.

    Ctrl-C and Ctrl-backslash still make signals. Ctrl-S and Ctrl-Z are switched off: they would
    freeze the screen in front of somebody who has one hand on an arm.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._descriptor = sys.stdin.fileno() if descriptor is None else descriptor
        self._before: list[Any] | None = None
        self._unfinished, self._unfinished_at = b"", 0.0

    def fileno(self) -> int:
        """The descriptor to wait on."""
        return self._descriptor

    def __enter__(self) -> "Keyboard":
        if sys.platform == "win32":
            raise NotImplementedError  # a ConsoleKeyboard reads there
        import termios

        self._before = termios.tcgetattr(self._descriptor)
        self.restore()
        return self

    def restore(self) -> None:
        """Set the terminal again as it must be, since a shell changed it while we were stopped."""
        if sys.platform == "win32":
            return
        import termios

        try:
            mode = termios.tcgetattr(self._descriptor)
        except termios.error:
            raise HangUp from None
        mode[0] &= ~(termios.IXON | termios.ICRNL)
        mode[3] &= ~(termios.ICANON | termios.ECHO)
        mode[6][termios.VMIN], mode[6][termios.VTIME] = 1, 0
        disabled = os.fpathconf(self._descriptor, "PC_VDISABLE")
        mode[6][termios.VSUSP] = bytes([disabled & 0xFF])
        termios.tcsetattr(self._descriptor, termios.TCSANOW, mode)

    def __exit__(self, *_: object) -> None:
        if sys.platform != "win32" and self._before is not None:
            import termios

            with suppress(termios.error):  # the terminal may be gone
                termios.tcflush(self._descriptor, termios.TCIFLUSH)
                termios.tcsetattr(self._descriptor, termios.TCSANOW, self._before)
            self._before = None

    def read(self) -> list[str]:
        """Return the keys that were pressed; call it when the descriptor is ready.

        A character stands for itself, in lower case; other keys have a name in :data:`NAMES`. Keys
        without a name, and Alt with a letter, are left out.

        Raises:
            HangUp: The terminal is gone.
        """
        try:
            pressed = self._received()
        except OSError:
            pressed = b""
        if not pressed:
            raise HangUp
        if clock.now() - self._unfinished_at < _ESCAPE_TIME:
            pressed = self._unfinished + pressed
        unfinished = _UNFINISHED.search(pressed)
        self._unfinished = unfinished[0] if unfinished else b""
        self._unfinished_at = clock.now()
        text = _UNFINISHED.sub(b"", pressed)
        names = [_name(match[0]) for match in _KEY.finditer(text)]
        return [name for name in names if name]

    def _received(self) -> bytes:
        return os.read(self._descriptor, 1024)


def _name(key: bytes) -> str:
    """Return a key's name; empty for one without."""
    text = key.decode("latin1")
    if text[:2] in ("\x1b[", "\x1bO"):
        return _SEQUENCES.get(text[2:], "")
    if text[:1] == "\x1b":
        return ""
    if text == " ":
        return "space"
    return _SINGLE.get(text, text.lower() if text.isascii() else "")


class ConsoleKeyboard(Keyboard):
    """Keys from a console of Windows, by msvcrt; a thread passes them on; not run there yet."""

    def __init__(self, console: Any) -> None:
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
                key = "\x1b" + _SPECIAL.get(self._console.getwch(), "[~")
            self._writer.send(key.encode())
        return True


HANG_UP = 1
"""SIGHUP, which Windows does not have."""
_NAMES = ("SIGHUP", "SIGINT", "SIGQUIT", "SIGTERM", "SIGBREAK", "SIGWINCH", "SIGCONT")
_KNOWN = {
    name: signal.Signals[name] for name in _NAMES if name in signal.Signals.__members__
}
"""Of this system."""


class Signals:
    """Notes the signals that end the program, and those of a terminal resized or given back."""

    def __init__(self) -> None:
        self.received: int | None = None
        """The first signal that asked the program to end."""
        self.continued = False
        """True if the program was stopped, and goes on."""
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "Signals":
        # Windows can wait on sockets, too.
        self._reader, self._writer = socket.socketpair()
        self._reader.setblocking(False)
        self._writer.setblocking(False)
        self._wakeup = signal.set_wakeup_fd(
            self._writer.fileno(), warn_on_full_buffer=False
        )
        for number in _KNOWN.values():
            self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._wakeup)
        self._reader.close()
        self._writer.close()

    def fileno(self) -> int:
        """The descriptor that becomes readable with a signal."""
        return self._reader.fileno()

    def read(self) -> None:
        """Empty the descriptor."""
        self._reader.recv(1024)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if number == _KNOWN.get("SIGCONT"):
            self.continued = True
        elif number != _KNOWN.get("SIGWINCH") and self.received is None:
            self.received = number
