"""Single key presses from a terminal, which is given back as it was whatever happens."""

import os
import re
import sys
import termios
from contextlib import suppress
from types import TracebackType
from typing import Any

from ..drivers import clock

__all__ = ["HangUp", "Keyboard"]

# Arrow keys, function keys, Alt with a letter: none of them may pass for a letter.
_ESCAPE = re.compile(rb"\x1b(\[[0-?]*[ -/]*[@-~]|O[ -~]|[^\[O])")
_UNFINISHED = re.compile(rb"\x1b(\[[0-?]*[ -/]*|O)?$")
_ESCAPE_TIME = 0.1
"""The rest of an escape sequence follows within this time [s]."""


class HangUp(Exception):  # noqa: N818 - an event, not a fault
    """The terminal is gone."""


class Keyboard:
    """Reads keys without waiting for Enter, and without showing them.

    Ctrl-C and Ctrl-backslash still make signals. Ctrl-S and Ctrl-Z are switched off: they would
    freeze the screen in front of somebody who has one hand on an arm.

    Args:
        descriptor: A terminal's file descriptor.
    """

    def __init__(self, descriptor: int | None = None) -> None:
        self._descriptor = sys.stdin.fileno() if descriptor is None else descriptor
        self._before: list[Any] | None = None
        self._unfinished, self._unfinished_at = b"", 0.0

    def fileno(self) -> int:
        """The descriptor to wait on."""
        return self._descriptor

    def __enter__(self) -> "Keyboard":
        self._before = termios.tcgetattr(self._descriptor)
        mode = termios.tcgetattr(self._descriptor)
        mode[0] &= ~(termios.IXON | termios.ICRNL)
        mode[3] &= ~(termios.ICANON | termios.ECHO)
        mode[6][termios.VMIN], mode[6][termios.VTIME] = 1, 0
        disabled = os.fpathconf(self._descriptor, "PC_VDISABLE")
        mode[6][termios.VSUSP] = bytes([disabled & 0xFF])
        termios.tcsetattr(self._descriptor, termios.TCSANOW, mode)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._before is not None:
            with suppress(termios.error):  # the terminal may be gone
                termios.tcflush(self._descriptor, termios.TCIFLUSH)
                termios.tcsetattr(self._descriptor, termios.TCSANOW, self._before)
            self._before = None

    def read(self) -> list[str]:
        """Return the keys that were pressed; call it when the descriptor is ready.

        Raises:
            HangUp: The terminal is gone.
        """
        try:
            pressed = os.read(self._descriptor, 1024)
        except OSError:
            pressed = b""
        if not pressed:
            raise HangUp
        if clock.now() - self._unfinished_at < _ESCAPE_TIME:
            pressed = self._unfinished + pressed
        pressed = _ESCAPE.sub(b"", pressed)
        unfinished = _UNFINISHED.search(pressed)
        self._unfinished = unfinished[0] if unfinished else b""
        self._unfinished_at = clock.now()
        return list(_UNFINISHED.sub(b"", pressed).decode(errors="ignore"))
