"""A TCP connection whose messages are taken off one by one, each by a deadline; and UDP sockets."""

import errno
import socket
from collections.abc import Callable, Iterator
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

    @property
    def hosts(self) -> tuple[str, str]:
        """Addresses of this computer and of the robot."""
        return self._socket.getsockname()[0], self._socket.getpeername()[0]

    def keep_alive(self) -> None:
        """Have a robot that vanishes noticed within seconds."""
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        # TCP_KEEPALIVE is what macOS calls TCP_KEEPIDLE
        for name in ("KEEPIDLE", "KEEPALIVE", "KEEPCNT", "KEEPINTVL"):
            option = getattr(socket, f"TCP_{name}", None)
            if option is not None:
                value = 3 if name == "KEEPCNT" else 1
                self._socket.setsockopt(socket.IPPROTO_TCP, option, value)

    @property
    def ended(self) -> bool:
        """True once the other side has ended the connection and nothing is left to read."""
        try:
            waits = clock.wait([self], 0)
            return bool(waits) and not self._socket.recv(1, socket.MSG_PEEK)
        except (OSError, ValueError):
            return True

    def send(self, message: bytes) -> None:
        """Send a message; a connection that has ended is UNREACHABLE."""
        try:
            self._socket.sendall(message)
        except OSError:
            raise self._ended() from None

    def take(
        self, splitter: Callable[[bytearray], Message | None], deadline: float
    ) -> Message:
        """Wait for a message until a time by :func:`.clock.now` [s], and return it.

        ``splitter`` takes it off the front of the bytes that have come. It returns None if it is
        not whole yet, and raises ValueError if the bytes are no messages.

        Raises:
            DriverError: SILENT when the message was not whole in time, UNREACHABLE when the
                connection has ended, PROTOCOL when the bytes are no messages: where the next one
                begins cannot be known then.
        """
        try:
            while (message := splitter(self._received)) is None:
                self._receive(deadline)
        except ValueError as error:
            raise Reason.PROTOCOL(f"{self._where} sends {error}") from None
        return message

    def take_line(self, deadline: float) -> bytes:
        """Wait for a line of at most 4096 bytes and return it, without its line break."""
        return self.take(_cut_line, deadline)

    def close(self) -> None:
        """End the connection; safe to call twice."""
        self._socket.close()

    def _receive(self, deadline: float) -> None:
        try:
            if not clock.wait([self], clock.left(deadline)):
                raise Reason.SILENT(f"no state from {self._where}")
            received = self._socket.recv(1 << 16)
        except (OSError, ValueError):  # a closed socket cannot be waited for
            raise self._ended() from None
        if not received:
            raise self._ended()
        self._received += received

    def _ended(self) -> DriverError:
        return Reason.UNREACHABLE(f"{self._where} ended the connection")


def cut(received: bytearray, count: int) -> bytes | None:
    """Take so many bytes off the front of what has come; None if there are fewer."""
    if len(received) < count:
        return None
    front = bytes(received[:count])
    del received[:count]
    return front


def _cut_line(received: bytearray) -> bytes | None:
    line, newline, _ = received.partition(b"\n")
    if len(line) > LONGEST_LINE:
        raise ValueError(f"{LONGEST_LINE} bytes without a line break")
    return (cut(received, len(line) + 1) or b"")[:-1] if newline else None


# Half a second of Franka's 2373 bytes at 1 kHz, twice over. Linux caps it at net.core.rmem_max.
BUFFER_BYTES = 4 << 20
LARGEST_DATAGRAM = 65535


class DatagramSocket:
    """A bound UDP socket that listens to one robot, by its IPv4 address, and tells of strangers.

    Raises:
        DriverError: BUSY when the port is taken, BAD_ADDRESS when it is none of this computer's.
    """

    def __init__(
        self, local: tuple[str, int], robot: str, on_stranger: Callable[[], None]
    ) -> None:
        self._robot = robot
        self._on_stranger = on_stranger
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        try:
            self._socket.bind(local)
        except OSError as error:
            self._socket.close()
            reason = (
                Reason.BUSY if error.errno == errno.EADDRINUSE else Reason.BAD_ADDRESS
            )
            raise DriverError(
                reason,
                f"UDP {local[0]}:{local[1]} cannot be opened here: {error.strerror}",
            ) from None

    @property
    def port(self) -> int:
        """The local port."""
        return self._socket.getsockname()[1]

    def until(self, deadline: float) -> Iterator[tuple[bytes, tuple[str, int]]]:
        """Yield the robot's datagrams, each with the address it came from, until time is up.

        A datagram that is waiting is yielded even if the time was up before. Only one is then, so
        that a flood of useless datagrams cannot keep the caller for ever.
        """
        while received := self._receive(deadline):
            if received[1][0] == self._robot:
                yield received
            else:
                self._on_stranger()
            if clock.now() > deadline:
                return

    def _receive(self, deadline: float) -> tuple[bytes, tuple[str, int]] | None:
        try:
            if not clock.wait([self._socket], clock.left(deadline)):
                return None
            return self._socket.recvfrom(LARGEST_DATAGRAM)
        except BlockingIOError:
            return None
        except (OSError, ValueError) as error:  # a closed socket cannot be waited for
            raise Reason.UNREACHABLE(f"the connection is lost: {error}") from None

    def send(self, datagram: bytes, target: tuple[str, int]) -> None:
        """Send one datagram; the network may lose it, as any."""
        try:
            self._socket.sendto(datagram, target)
        except OSError as error:
            raise Reason.UNREACHABLE(
                f"the connection is lost: {error.strerror}"
            ) from None

    def close(self) -> None:
        """Free the port; safe to call twice."""
        self._socket.close()
