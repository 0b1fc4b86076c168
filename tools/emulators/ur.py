"""Universal Robots' controller: RTDE outputs over TCP, of a CB3 or e-series.

Proven against ur-rtde 1.6.5, whose requests it was written from.
"""

import socket
import struct

from ...drivers import JointState
from ...drivers.transport import parse_endpoint
from .emulator import Emulator
from .sabotage import COMMON_KINDS

TYPES = {
    "timestamp": "DOUBLE",
    "actual_q": "VECTOR6D",
    "target_moment": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_mode": "INT32",
}
RUNNING, NORMAL = 7, 1


class UrEmulator(Emulator):
    """A controller of one software version, with one client."""

    JOINTS = 6
    VERSIONS = ("5.11", "3.15", "10.7")
    RATES = {"5.11": 500.0, "3.15": 125.0, "10.7": 500.0}  # noqa: RUF012
    FAULTS = (*COMMON_KINDS, "version")

    def listen(self, address: str) -> None:
        """Open TCP port 30004."""
        endpoint = parse_endpoint(address, 30004, default_host="127.0.0.1")
        self._client: socket.socket | None = None
        self._server = socket.create_server((endpoint.host, endpoint.port))
        self.watch(self._server.fileno(), self._accept)
        self._forget()

    @property
    def driver_address(self) -> str:
        """HOST:PORT."""
        host, port = self._server.getsockname()
        return f"ur:{host}:{port}"

    @property
    def streaming(self) -> bool:
        """Whether the client has started the stream."""
        return self._started

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send one data package."""
        if self.sabotage.strikes("hangup", moment):
            self._hang_up()
            return
        if number % self._every:
            return
        package = packed(b"U", b"\x01" + self._values(number, state))
        for _, payload in self.packets(package, moment):
            self._send(payload)

    def _values(self, number: int, state: JointState) -> bytes:
        values = {
            "timestamp": struct.pack(">d", number / self.arm.rate),
            "actual_q": struct.pack(">6d", *state.position),
            "target_moment": struct.pack(">6d", *(state.effort or 6 * (0.0,))),
            "robot_mode": struct.pack(">i", RUNNING),
            "safety_mode": struct.pack(">i", NORMAL),
        }
        return b"".join(values[name] for name in self._names)

    def _accept(self) -> None:
        client, _ = self._server.accept()
        held = self._client is not None
        if held or any(self.sabotage.strikes(kind, self.moment) for kind in ("busy", "hangup")):
            client.close()
            return
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client
        self.watch(client.fileno(), self._requests)

    def _requests(self) -> None:
        """Answer all requests that have come in whole."""
        assert self._client is not None
        try:
            received = self._client.recv(4096)
        except ConnectionError:
            received = b""
        if not received:
            self._hang_up()
            return
        self.journal.received("tcp", received)
        self._buffer += received
        while len(self._buffer) >= 3:
            size = int.from_bytes(self._buffer[:2], "big")
            if len(self._buffer) < size:
                break
            package, self._buffer = self._buffer[:size], self._buffer[size:]
            self._answer(package[2:3], package[3:])

    def _answer(self, kind: bytes, payload: bytes) -> None:
        if kind == b"V":
            known = payload == b"\0\2" and not self.sabotage.strikes("version", self.moment)
            self._send(packed(kind, bytes([known])))
        elif kind == b"v":
            major, minor = map(int, self.version.split("."))
            self._send(packed(kind, struct.pack(">4I", major, minor, 0, 0)))
        elif kind == b"O":
            self._set_up(payload)
        elif kind in (b"S", b"P"):
            self._send(packed(kind, b"\x01"))
            self._started = kind == b"S"
            self.begin()

    def _set_up(self, payload: bytes) -> None:
        (frequency,) = struct.unpack_from(">d", payload)
        self._every = max(1, round(self.arm.rate / frequency))
        self._names = payload[8:].decode().rstrip(",").split(",")
        types = ",".join(TYPES.get(name, "NOT_FOUND") for name in self._names)
        self._send(packed(b"O", bytes(["NOT_FOUND" not in types]) + types.encode()))

    def _send(self, package: bytes) -> None:
        assert self._client is not None
        try:
            self._client.sendall(package)
        except ConnectionError:
            self._hang_up()

    def _hang_up(self) -> None:
        if self._client is not None:
            self.unwatch(self._client.fileno())
            self._client.close()
        self._forget()

    def _forget(self) -> None:
        self._client = None
        self._buffer = b""
        self._names: list[str] = []
        self._every = 1
        self._started = False


def packed(kind: bytes, payload: bytes) -> bytes:
    """Return an RTDE package."""
    return struct.pack(">H", 3 + len(payload)) + kind + payload
