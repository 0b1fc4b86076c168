"""A controller's ports: TCP, UDP, a serial line, a CAN bus; none holds an emulator up."""

import os
import socket
import sys
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial

import can

from ...drivers import clock
from ...drivers.transport import open_bus, parse_can_address
from ...errors import MukcaError
from .emulator import Emulator

MOST_BYTES = 65535
SEND_SECONDS = 0.1
"""A client that reads nothing for so long is hung up on [s]."""
PAUSE = 0.05
"""A message on a line that stops for so long has ended [s]."""
STRANGER = ("127.66.66.66", 0)
"""A loopback address that is no robot's."""
DEFAULT_BUS = "udp_multicast/239.74.163.2?port=43113&hop_limit=0"

Receiver = Callable[[bytes], object]


def _ignore(*_: object) -> None:
    """Ignore a message, or a client that joins or leaves."""


class TcpServer:
    """A TCP port; ``on_join`` and ``on_leave`` are called for each client."""

    def __init__(
        self,
        emulator: Emulator,
        address: tuple[str, int],
        receiver: Receiver = _ignore,
        channel: str = "tcp",
        places: int = 1,
    ) -> None:
        self.clients: list[socket.socket] = []
        self.on_join: Callable[[], object] = _ignore
        self.on_leave: Callable[[], object] = _ignore
        self._emulator, self._receiver, self._channel = emulator, receiver, channel
        self._places = places
        self._server = emulator.opened.enter_context(socket.create_server(address))
        self.address = "{}:{}".format(*self._server.getsockname())
        emulator.watched[self._server.fileno()] = self._accept
        emulator.on_away.append(self.hang_up)
        emulator.opened.callback(self.hang_up)

    def send(self, message: bytes, _: object = None) -> None:
        """Send a message to all clients."""
        for client in list(self.clients):
            try:
                client.sendall(message)
            except OSError:
                self._drop(client)

    def hang_up(self) -> None:
        """End all connections."""
        for client in list(self.clients):
            self._drop(client)

    def _accept(self) -> None:
        with suppress(OSError):  # it may have left already
            client, _ = self._server.accept()
            is_away = self._emulator.is_away(self._emulator.moment)
            if is_away or len(self.clients) >= self._places:
                client.close()
                return
            client.settimeout(SEND_SECONDS)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.clients.append(client)
            self._emulator.watched[client.fileno()] = partial(self._receive, client)
            self.on_join()

    def _receive(self, client: socket.socket) -> None:
        try:
            message = client.recv(MOST_BYTES)
        except OSError:
            message = b""
        if not message:
            self._drop(client)
            return
        self._emulator.journal.received(self._channel, message)
        if self._emulator.faults.is_active("silent", self._emulator.moment):
            return
        try:
            self._receiver(message)
        except (OSError, ValueError):  # it has left, or makes no sense
            self._drop(client)

    def _drop(self, client: socket.socket) -> None:
        if client in self.clients:
            self.clients.remove(client)
            self._emulator.watched.pop(client.fileno(), None)
            client.close()
            self.on_leave()


class UdpPort:
    """A UDP port."""

    def __init__(
        self,
        emulator: Emulator,
        address: tuple[str, int],
        receiver: Receiver = _ignore,
    ) -> None:
        self._emulator, self._receiver = emulator, receiver
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        emulator.opened.enter_context(self._socket)
        self._socket.setblocking(False)
        self._socket.bind(address)
        self.address = "{}:{}".format(*self._socket.getsockname())
        emulator.watched[self._socket.fileno()] = self._receive

    def send(self, datagram: bytes, target: tuple[str, int]) -> None:
        """Send a datagram; nobody need listen."""
        with suppress(OSError):
            self._socket.sendto(datagram, target)

    def _receive(self) -> None:
        with suppress(OSError):
            datagram = self._socket.recv(MOST_BYTES)
            self._emulator.journal.received("udp", datagram)
            self._receiver(datagram)


class SerialPort:
    """One end of a pseudo-terminal, whose other end has the name ``name``."""

    def __init__(
        self,
        emulator: Emulator,
        address: str,
        receiver: Callable[[bytearray], object],
    ) -> None:
        if address:
            kind = type(emulator).__name__.removesuffix("Emulator").lower()
            raise MukcaError(f"{kind} opens a terminal of its own; leave --address out")
        self._line, self.name = _open_terminal()
        emulator.opened.callback(os.close, self._line)
        self._journal = emulator.journal
        self._receiver, self._received, self._last = receiver, bytearray(), 0.0
        emulator.watched[self._line] = self._receive

    def send(self, message: bytes, _: object = None) -> None:
        """Send bytes; those for which there is no room are lost."""
        with suppress(OSError):
            os.write(self._line, message)

    def _receive(self) -> None:
        before = self._last
        self._last = clock.now()
        if self._last > before + PAUSE:
            self._received.clear()
        with suppress(OSError):
            message = os.read(self._line, MOST_BYTES)
            self._journal.received("line", message)
            self._received += message
        self._receiver(self._received)


def _open_terminal() -> tuple[int, str]:
    """Return the descriptor of a pseudo-terminal's one end, and the name of its other."""
    if sys.platform == "win32":
        raise MukcaError(
            "Windows has no pseudo-terminals: emulate this controller elsewhere"
        )
    import tty

    line, terminal = os.openpty()
    tty.setraw(line)
    tty.setraw(terminal)
    os.set_blocking(line, False)
    return line, os.ttyname(terminal)


class CanPort:
    """A node on a CAN bus; the receiver is given each frame of others, by identifier and data."""

    def __init__(
        self,
        emulator: Emulator,
        address: str,
        receiver: Callable[[int, bytes], object] = _ignore,
    ) -> None:
        self.address = address or DEFAULT_BUS
        self._journal, self._receiver = emulator.journal, receiver
        self._sent: deque[tuple[int, bytes]] = deque(maxlen=100)
        self._bus = open_bus(parse_can_address(self.address))
        emulator.opened.callback(self._bus.shutdown)
        emulator.watched[self._bus.fileno()] = self._receive

    def send(self, data: bytes, identifier: int) -> None:
        """Send a frame."""
        with suppress(can.CanError, OSError):
            frame = can.Message(
                arbitration_id=identifier,
                data=data,
                is_extended_id=False,
            )
            self._sent.append((identifier, data))
            self._bus.send(frame)

    def _receive(self) -> None:
        if (frame := self._bus.recv(0)) is None:
            return
        identifier = frame.arbitration_id
        data = bytes(frame.data)
        if (identifier, data) in self._sent:  # some buses bring back what was sent
            self._sent.remove((identifier, data))
        else:
            self._journal.received(f"{identifier:03x}", data)
            self._receiver(identifier, data)
