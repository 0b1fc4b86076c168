"""A serial port, opened not to block, whose errors are the driver's own."""

import sys
from collections.abc import Callable
from typing import Any, TypeVar

import serial

from .. import Reason, clock
from .address import lost

TerminalError: type[Exception] = getattr(sys.modules.get("termios"), "error", OSError)
"""Error of terminals that pyserial lets pass."""
MOST_BYTES = 4096


class SerialLine:
    """A serial port that no other program may use meanwhile; its settings are pyserial's.

    Raises:
        DriverError: BAD_ADDRESS for settings that no line has, UNREACHABLE if it cannot be opened.
    """

    def __init__(self, port: str, baud: int, **settings: Any) -> None:
        try:
            self._port = serial.Serial(
                port,
                baud,
                timeout=0,
                write_timeout=1,  # s: a line that nobody reads fills up, and would block for ever
                exclusive=True,
                **settings,
            )
        except ValueError as error:
            raise Reason.BAD_ADDRESS(f"serial port {port}: {error}") from None
        except (OSError, TerminalError) as error:
            raise Reason.UNREACHABLE(
                f"serial port {port} cannot be opened: {error}; is the adapter plugged in, does "
                "another program use it, and are you in the group dialout?"
            ) from None

    def write(self, message: bytes) -> None:
        """Send bytes."""
        with lost(
            f"serial port {self._port.port}", TypeError, ValueError, TerminalError
        ):
            self._port.write(message)

    def read(self, count: int, wait: float) -> bytes:
        """Return at most so many bytes, as soon as one has come; none after the wait [s]."""
        with lost(
            f"serial port {self._port.port}", TypeError, ValueError, TerminalError
        ):
            if sys.platform == "win32":  # where a port is nothing to wait on
                self._port.timeout = max(0.0, wait)
                first = bytes(self._port.read(1))
                return first + bytes(
                    self._port.read(min(count - 1, self._port.in_waiting))
                )
            if not clock.wait([self._port], max(0.0, wait)):
                return b""
            return bytes(self._port.read(count))

    def discard(self, wait: float) -> bool:
        """Throw away what has come, or comes within the wait [s]; return whether anything did."""
        return bool(self.read(MOST_BYTES, wait))

    def close(self) -> None:
        """Free the port; safe to call twice."""
        self._port.close()


QUIET = 0.05  # s: all that a line held back has come if nothing more does for so long
LONGEST_DRAIN = 0.5  # s: another program may use the line, so that it is never quiet

Answer = TypeVar("Answer")


class FreshAnswers:
    """Requests on a line whose answers carry no number, one at a time.

    Before each, what waits is thrown away. After one that nobody answered in time, as after another
    program's, an answer may be late by as long as the line stalled. So the first answer then is not
    believed: the line is emptied until it is quiet, and the request is sent again. ``discard`` is
    that of :class:`SerialLine`, or another's.
    """

    def __init__(self, discard: Callable[[float], bool]) -> None:
        self._discard = discard
        self._owed = True

    def ask(self, request: Callable[[], Answer], until: float = 0.0) -> Answer:
        """Return the answer to a request, which raises ValueError where none comes in time."""
        while True:
            self._drain(0.0)
            owed, self._owed = self._owed, True
            try:
                answer = request()
            except ValueError:
                if clock.now() >= until:
                    raise
                continue
            self._owed = False
            if not owed:
                return answer
            self._drain(QUIET)

    def _drain(self, quiet: float) -> None:
        end = clock.now() + LONGEST_DRAIN
        while self._discard(quiet) and clock.now() < end:
            pass
