"""A serial port, opened not to block, whose errors are the driver's own."""

import sys
from typing import Any

import serial

from .. import DriverError, Reason, clock
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
            raise DriverError(Reason.BAD_ADDRESS, f"serial port {port}: {error}") from None
        except (OSError, TerminalError) as error:
            raise DriverError(
                Reason.UNREACHABLE,
                f"serial port {port} cannot be opened: {error}; is the adapter plugged in, does "
                "another program use it, and are you in the group dialout?",
            ) from None

    def write(self, message: bytes) -> None:
        """Send bytes."""
        with lost(f"serial port {self._port.port}", TypeError, ValueError, TerminalError):
            self._port.write(message)

    def read(self, most: int, wait: float) -> bytes:
        """Return at most so many bytes, as soon as one has come; none after the wait [s]."""
        with lost(f"serial port {self._port.port}", TypeError, ValueError, TerminalError):
            if sys.platform == "win32":  # where a port is nothing to wait on
                self._port.timeout = max(0.0, wait)
                first = bytes(self._port.read(1))
                return first + bytes(self._port.read(min(most - 1, self._port.in_waiting)))
            if not clock.wait([self._port], max(0.0, wait)):
                return b""
            return bytes(self._port.read(most))

    def discard(self, wait: float) -> bool:
        """Throw away what has come, or comes within the wait [s]; return whether anything did."""
        return bool(self.read(MOST_BYTES, wait))

    def close(self) -> None:
        """Free the port; safe to call twice."""
        self._port.close()
