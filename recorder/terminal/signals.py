"""Signals that a loop looks at between two steps, instead of being interrupted by them."""

import signal
import socket
from types import FrameType
from typing import Any

HANG_UP = 1
"""SIGHUP, which Windows does not have."""
_NAMES = ("SIGHUP", "SIGINT", "SIGQUIT", "SIGTERM", "SIGBREAK", "SIGWINCH")
_KNOWN = {name: signal.Signals[name] for name in _NAMES if name in signal.Signals.__members__}
"""Of this system."""


class Signals:
    """Notes the signals that end the program, and the one for a resized terminal."""

    def __init__(self) -> None:
        self.received: int | None = None
        """The first signal that asked the program to end."""
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "Signals":
        self._reader, self._writer = socket.socketpair()  # what Windows can wait on, too
        self._reader.setblocking(False)
        self._writer.setblocking(False)
        self._wakeup = signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
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
        if number != _KNOWN.get("SIGWINCH") and self.received is None:
            self.received = number
