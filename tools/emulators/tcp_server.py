"""A controller's TCP port: clients are accepted, heard, answered and hung up on."""

import socket
from collections.abc import Callable
from functools import partial

from .emulator import Emulator


class TcpServer:
    """A port of an emulator.

    Args:
        emulator: Its faults decide who is accepted, its journal notes what comes in.
        address: Host and port.
        channel: Name of the port in the journal.
        clients: Number of clients that it serves at a time.
    """

    def __init__(
        self, emulator: Emulator, address: tuple[str, int], channel: str = "tcp", clients: int = 1
    ) -> None:
        self.clients: list[socket.socket] = []
        self.on_join: Callable[[], object] = bool
        self.on_message: Callable[[bytes], object] = bool
        self.on_leave: Callable[[], object] = bool
        self._emulator, self._channel, self._places = emulator, channel, clients
        self._server = socket.create_server(address)
        emulator.watch(self._server.fileno(), self._accept)
        emulator.opened.callback(self._close)

    @property
    def address(self) -> str:
        """HOST:PORT."""
        host, port = self._server.getsockname()
        return f"{host}:{port}"

    def send(self, message: bytes) -> None:
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
        client, _ = self._server.accept()
        if len(self.clients) >= self._places or self._emulator.is_away(self._emulator.moment):
            client.close()
            return
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.clients.append(client)
        self._emulator.watch(client.fileno(), partial(self._hear, client))
        self.on_join()

    def _hear(self, client: socket.socket) -> None:
        try:
            message = client.recv(4096)
        except OSError:
            message = b""
        if message:
            self._emulator.journal.received(self._channel, message)
            self.on_message(message)
        else:
            self._drop(client)

    def _drop(self, client: socket.socket) -> None:
        if client in self.clients:
            self.clients.remove(client)
            self._emulator.unwatch(client.fileno())
            client.close()
            self.on_leave()

    def _close(self) -> None:
        for one in (self._server, *self.clients):
            one.close()
