"""Datagrams from one robot: everything that another host sends is counted and thrown away."""

import errno
import socket
from collections.abc import Callable, Iterator

from .. import DriverError, Reason, clock

# Half a second of Franka's 2373 bytes at 1 kHz, twice over. Linux caps it at net.core.rmem_max.
BUFFER_BYTES = 4 << 20
LARGEST_DATAGRAM = 65535


class DatagramSocket:
    """A bound UDP socket that listens to one robot, by its IPv4 address, and tells of strangers.

    Raises:
        DriverError: BUSY when the port is taken, BAD_ADDRESS when it is none of this computer's.
    """

    def __init__(self, local: tuple[str, int], robot: str, on_stranger: Callable[[], None]) -> None:
        self._robot = robot
        self._on_stranger = on_stranger
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        try:
            self._socket.bind(local)
        except OSError as error:
            self._socket.close()
            reason = Reason.BUSY if error.errno == errno.EADDRINUSE else Reason.BAD_ADDRESS
            raise DriverError(
                reason, f"UDP {local[0]}:{local[1]} cannot be opened here: {error.strerror}"
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
        while (received := self._receive(deadline)) is not None:
            if received[1][0] == self._robot:
                yield received
            else:
                self._on_stranger()
            if clock.now() > deadline:
                return

    def _receive(self, deadline: float) -> tuple[bytes, tuple[str, int]] | None:
        try:
            if not clock.wait([self._socket], max(0.0, deadline - clock.now())):
                return None
            return self._socket.recvfrom(LARGEST_DATAGRAM)
        except BlockingIOError:
            return None
        except (OSError, ValueError) as error:  # a closed socket cannot be waited for
            raise DriverError(Reason.UNREACHABLE, f"the connection is lost: {error}") from None

    def send(self, datagram: bytes, target: tuple[str, int]) -> None:
        """Send one datagram; the network may lose it, as any."""
        try:
            self._socket.sendto(datagram, target)
        except OSError as error:
            raise DriverError(
                Reason.UNREACHABLE, f"the connection is lost: {error.strerror}"
            ) from None

    def close(self) -> None:
        """Free the port; safe to call twice."""
        self._socket.close()
