"""Universal Robots' RTDE outputs, CB3 or e-series; proven against ur-rtde 1.6.5."""

import struct

from ...drivers import JointState
from ...drivers.transport import parse_endpoint
from .arm import COMMON_KINDS
from .emulator import Emulator, Version
from .ports import TcpServer

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

    VERSIONS = {  # noqa: RUF012
        "5.11": Version(6, 500.0),
        "3.15": Version(6, 125.0),
        "10.7": Version(6, 500.0),
    }
    FAULTS = (*COMMON_KINDS, "version")

    def listen(self, address: str) -> None:
        """Open TCP port 30004."""
        endpoint = parse_endpoint(address, 30004, default_host="127.0.0.1")
        self._tcp = TcpServer(self, (endpoint.host, endpoint.port), self._requests)
        self._tcp.on_leave = self._forget
        self.driver_address = f"ur:{self._tcp.address}"
        self._forget()

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send one data package."""
        if number % self._every == 0:
            package = packed(b"U", b"\x01" + self._values(number, state))
            self.emit(self._tcp.send, package, moment)

    def _values(self, number: int, state: JointState) -> bytes:
        values = {
            "timestamp": struct.pack(">d", number / self.arm.rate),
            "actual_q": struct.pack(">6d", *state.position),
            "target_moment": struct.pack(">6d", *(state.effort or 6 * (0.0,))),
            "robot_mode": struct.pack(">i", RUNNING),
            "safety_mode": struct.pack(">i", NORMAL),
        }
        return b"".join(values[name] for name in self._names)

    def _requests(self, received: bytes) -> None:
        """Answer all requests that have come in whole."""
        self._buffer += received
        while len(self._buffer) >= 3:
            size = int.from_bytes(self._buffer[:2], "big")
            if size < 3:
                raise ValueError("a package that ends before it begins")
            if len(self._buffer) < size:
                break
            package, self._buffer = self._buffer[:size], self._buffer[size:]
            self._answer(package[2:3], package[3:])

    def _answer(self, kind: bytes, payload: bytes) -> None:
        if kind == b"V":
            known = payload == b"\0\2" and not self.faults.is_active("version", self.moment)
            self._tcp.send(packed(kind, bytes([known])))
        elif kind == b"v":
            major, minor = map(int, self.version.split("."))
            self._tcp.send(packed(kind, struct.pack(">4I", major, minor, 0, 0)))
        elif kind == b"O":
            self._set_up(payload)
        elif kind in (b"S", b"P"):
            self._tcp.send(packed(kind, b"\x01"))
            self.streaming = kind == b"S"
            self.begin()

    def _set_up(self, payload: bytes) -> None:
        if len(payload) < 8 or not (frequency := struct.unpack_from(">d", payload)[0]) > 0:
            raise ValueError("outputs at no rate")
        self._every = max(1, round(self.arm.rate / frequency))
        self._names = payload[8:].decode().rstrip(",").split(",")
        types = ",".join(TYPES.get(name, "NOT_FOUND") for name in self._names)
        self._tcp.send(packed(b"O", bytes(["NOT_FOUND" not in types]) + types.encode()))

    def _forget(self) -> None:
        self._buffer = b""
        self._names: list[str] = []
        self._every = 1
        self.streaming = False


def packed(kind: bytes, payload: bytes) -> bytes:
    """Return an RTDE package."""
    return struct.pack(">H", 3 + len(payload)) + kind + payload
