"""Signals that a loop looks at between two steps, instead of being interrupted by them.

A signal handler that raises an exception may do so anywhere, for instance between a write and its
sync. Here a signal is only noted, and wakes the loop if it waits.
"""

import os
import signal
from types import FrameType
from typing import Any

_ENDING = (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM)


class Signals:
    """Notes the signals that end the program, and the one for a resized terminal."""

    def __init__(self) -> None:
        self.received: int | None = None
        """The first signal that asked the program to end."""
        self._before: dict[int, Any] = {}

    def __enter__(self) -> "Signals":
        self._reader, self._writer = os.pipe()
        os.set_blocking(self._reader, False)
        os.set_blocking(self._writer, False)
        self._wakeup = signal.set_wakeup_fd(self._writer, warn_on_full_buffer=False)
        for number in (*_ENDING, signal.SIGWINCH):
            self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._wakeup)
        os.close(self._reader)
        os.close(self._writer)

    def fileno(self) -> int:
        """The descriptor that becomes readable with a signal."""
        return self._reader

    def read(self) -> None:
        """Empty the descriptor."""
        os.read(self._reader, 1024)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if number != signal.SIGWINCH and self.received is None:
            self.received = number
