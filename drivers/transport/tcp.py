"""A TCP connection whose bytes are taken off message by message, each by a deadline."""

from collections.abc import Callable
from typing import TypeVar

from .. import DriverError, Reason, clock
from .address import Endpoint, open_tcp

Message = TypeVar("Message")
LONGEST_LINE = 4096


class TcpStream:
    """A connection to a robot that sends messages over TCP, or UNREACHABLE, with advice."""

    def __init__(self, endpoint: Endpoint, advice: str) -> None:
        self._where = f"the robot at {endpoint}"
        self._received = bytearray()
        self._socket = open_tcp(endpoint, advice)

    def fileno(self) -> int:
        """The socket's descriptor, to wait on."""
        return self._socket.fileno()

    def send(self, message: bytes) -> None:
        """Send a message; a connection that has ended is UNREACHABLE."""
        try:
            self._socket.sendall(message)
        except OSError:
            raise self._ended() from None

    def take(self, cut: Callable[[bytearray], Message | None], deadline: float) -> Message:
        """Wait for a message until a time by :func:`.clock.now` [s], and return it.

        ``cut`` takes it off the front of the bytes that have come; it returns None if it is not
        whole yet, and raises ValueError if the bytes are no messages.

        Raises:
            DriverError: SILENT when the message was not whole in time, UNREACHABLE when the
                connection has ended, PROTOCOL when the bytes are no messages: where the next one
                begins cannot be known then.
        """
        try:
            while (message := cut(self._received)) is None:
                self._receive(deadline)
        except ValueError as error:
            raise DriverError(Reason.PROTOCOL, f"{self._where} sends {error}") from None
        return message

    def take_line(self, deadline: float) -> bytes:
        """Wait for a line of at most 4096 bytes and return it, without its line break."""
        return self.take(_cut_line, deadline)

    def close(self) -> None:
        """End the connection; safe to call twice."""
        self._socket.close()

    def _receive(self, deadline: float) -> None:
        try:
            if not clock.wait([self], max(0.0, deadline - clock.now())):
                raise DriverError(Reason.SILENT, f"no state from {self._where}")
            received = self._socket.recv(1 << 16)
        except (OSError, ValueError):  # a closed socket cannot be waited for
            raise self._ended() from None
        if not received:
            raise self._ended()
        self._received += received

    def _ended(self) -> DriverError:
        return DriverError(Reason.UNREACHABLE, f"{self._where} ended the connection")


def _cut_line(received: bytearray) -> bytes | None:
    line, newline, _ = received.partition(b"\n")
    if len(line) > LONGEST_LINE:
        raise ValueError(f"{LONGEST_LINE} bytes without a line break")
    if not newline:
        return None
    del received[: len(line) + 1]
    return bytes(line)
