"""A UFACTORY controller's report ports.

Proven against UFACTORY's own package, xarm-python-sdk 1.18.4: its structures read these reports.
"""

import socket
import struct
from functools import partial

from ...drivers import JointState
from .emulator import Emulator

HOST = "127.0.0.1"
RICH, NORMAL_SIZE, RICH_SIZE = 30002, 145, 233
GUIDING = 0x22  # mode 2, joint teaching; state 2
FIRST_TIME = 5_000_000  # us


class XArmEmulator(Emulator):
    """A controller with some of its report ports, named by its arm: with or without port 30000."""

    JOINTS = 6
    VERSIONS = ("xarm6", "xarm6-old", "xarm7", "xarm5")
    RATES = {"xarm6": 250.0, "xarm6-old": 100.0, "xarm7": 250.0, "xarm5": 250.0}  # noqa: RUF012

    @classmethod
    def joints(cls, version: str) -> int:
        """Return how many joints the arm of a version has."""
        return int(version.removeprefix("xarm")[0])

    def listen(self, address: str) -> None:
        """Listen on the report ports."""
        self._host = address or HOST
        self._port = 30003 if self.version.endswith("old") else 30000
        self._clients: dict[int, list[socket.socket]] = {self._port: [], RICH: []}
        self.listeners: list[socket.socket] = []
        for port in self._clients:
            listener = socket.create_server((self._host, port))
            self.listeners.append(listener)
            self.watch(listener.fileno(), partial(self._accept, listener, port))

    @property
    def driver_address(self) -> str:
        """The host."""
        return f"xarm:{self._host}"

    @property
    def streaming(self) -> bool:
        """Whether anybody listens to the fast port."""
        return bool(self._clients[self._port])

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send a report to whoever listens to the fast port."""
        if self.sabotage.strikes("hangup", moment):
            for client in list(self._clients[self._port]):
                self._leave(client, self._port)
            return
        report = self._fast(number, state) if self._port == 30000 else self._real(state)
        for _, packet in self.packets(report, moment):
            for client in list(self._clients[self._port]):
                self._send(client, self._port, packet)

    def close(self) -> None:
        """Close the ports."""
        for some in (self.listeners, *self._clients.values()):
            for one in some:
                one.close()

    def _accept(self, listener: socket.socket, port: int) -> None:
        client, _ = listener.accept()
        moment = self.moment
        if any(self.sabotage.strikes(kind, moment) for kind in ("hangup", "busy")):
            client.close()
            return
        self._clients[port].append(client)
        self.watch(client.fileno(), partial(self._hear, client, port))
        self.begin()
        if port == RICH:
            self._send(client, port, self._rich(self.arm.state(0.0)))

    def _hear(self, client: socket.socket, port: int) -> None:
        """Note what a client sends, which it should not."""
        try:
            message = client.recv(4096)
        except OSError:
            message = b""
        if message:
            self.journal.received(str(port), message)
        else:
            self._leave(client, port)

    def _send(self, client: socket.socket, port: int, report: bytes) -> None:
        try:
            client.sendall(report)
        except OSError:
            self._leave(client, port)

    def _leave(self, client: socket.socket, port: int) -> None:
        if client in self._clients[port]:
            self._clients[port].remove(client)
            self.unwatch(client.fileno())
            client.close()

    def _seven(self, values: tuple[float, ...]) -> bytes:
        return struct.pack("<7f", *values, *[0.0] * (7 - len(values)))

    def _real(self, state: JointState) -> bytes:
        torques = self._seven(state.effort or (0.0,) * len(state.position))
        body = bytes([GUIDING]) + bytes(2) + self._seven(state.position) + bytes(24) + torques
        return (len(body) + 4).to_bytes(4, "big") + body

    def _fast(self, number: int, state: JointState) -> bytes:
        time = FIRST_TIME + round(number * 1e6 / self.arm.rate)
        head = time.to_bytes(8, "big") + bytes([GUIDING]) + bytes(2 + 17)
        still = bytes(28)
        targets = self._seven(tuple(q + 1e-3 for q in state.position)) + still + still
        actual = self._seven(state.position) + still + still
        torques = still + self._seven(state.effort or (0.0,) * len(state.position))
        body = head + targets + actual + torques
        body += bytes(804 - 4 - len(body))
        return (804).to_bytes(4, "big") + body

    def _rich(self, state: JointState) -> bytes:
        body = self._real(state)[4:]
        body += bytes(NORMAL_SIZE - 4 - len(body))
        body += bytes([6, len(state.position), 0xAA, 0x55]) + bytes(2) + b"v2.6.0".ljust(30, b"\0")
        body += bytes(RICH_SIZE - 4 - len(body))
        return RICH_SIZE.to_bytes(4, "big") + body
