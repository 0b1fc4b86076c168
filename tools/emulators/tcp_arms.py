"""Controllers that report over TCP: Universal Robots' RTDE, and UFACTORY's report ports.

Proven against ur-rtde 1.6.5, CB3 and e-series, and xarm-python-sdk 1.18.4.
"""

import struct
from collections.abc import Sequence
from functools import partial

from ...drivers import JointState
from ...drivers.arms import encode_package, take_package
from ...drivers.transport import parse_endpoint
from .arm import COMMON_KINDS
from .emulator import Emulator, Version
from .ports import TcpServer

OUTPUTS = {
    "timestamp": ("DOUBLE", ">d"),
    "actual_q": ("VECTOR6D", ">6d"),
    "target_moment": ("VECTOR6D", ">6d"),
    "robot_mode": ("INT32", ">i"),
    "safety_mode": ("INT32", ">i"),
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

        def receive(received: bytes) -> None:
            self._buffer += received
            while package := take_package(self._buffer):
                self._answer(*package)

        self._tcp = TcpServer(self, (endpoint.host, endpoint.port), receive)
        self._tcp.on_leave = self._forget
        self.driver_address = f"ur:{self._tcp.address}"
        self._forget()

    def send_state(self, state: JointState, moment: float) -> None:
        """Send one data package."""
        if self.number % self._every == 0:
            values = {
                "timestamp": [self.number / self.arm.rate],
                "actual_q": state.position,
                "target_moment": state.effort or 6 * (0.0,),
                "robot_mode": [RUNNING],
                "safety_mode": [NORMAL],
            }
            outputs = [
                struct.pack(OUTPUTS[name][1], *values[name]) for name in self._names
            ]
            package = encode_package(ord("U"), b"".join([b"\x01", *outputs]))
            self.emit(self._tcp.send, package, moment)

    def _answer(self, kind: int, payload: bytes) -> None:
        match chr(kind):
            case "V":
                other_version = self.faults.is_active("version", self.moment)
                answer = bytes([payload == b"\0\2" and not other_version])
            case "v":
                major, minor = map(int, self.version.split("."))
                answer = struct.pack(">4I", major, minor, 0, 0)
            case "O":
                answer = self._set_up(payload)
            case "S" | "P" as word:
                answer = b"\x01"
                self.streaming = word == "S"
                self.arm.connect()
            case _:
                return
        self._tcp.send(encode_package(kind, answer))

    def _set_up(self, payload: bytes) -> bytes:
        """Take note of the outputs that are asked for; return their types."""
        frequency = struct.unpack_from(">d", payload)[0] if len(payload) >= 8 else 0.0
        if not frequency >= 1e-3:  # nor NaN
            raise ValueError("outputs at no rate")
        self._every = max(1, round(self.arm.rate / frequency))
        names = payload[8:].decode().rstrip(",").split(",")
        types = [OUTPUTS.get(name, ("NOT_FOUND",))[0] for name in names]
        self._names = [] if "NOT_FOUND" in types else names
        return bytes([bool(self._names)]) + ",".join(types).encode()

    def _forget(self) -> None:
        self._buffer = bytearray()
        self._names: list[str] = []
        self._every = 1
        self.streaming = False


HOST = "127.0.0.1"
RICH = 30002
REAL_SIZE, NORMAL_SIZE, RICH_SIZE, FAST_SIZE = 87, 145, 233, 804
GUIDING = 0x22  # mode 2, joint teaching; state 2
FIRST_TIME = 5_000_000  # us
MOST_CLIENTS = 100


class XArmEmulator(Emulator):
    """A controller with some of its report ports, named by its arm: with or without port 30000."""

    VERSIONS = {  # noqa: RUF012
        "xarm6": Version(6, 250.0),
        "xarm6-old": Version(6, 100.0),
        "xarm7": Version(7, 250.0),
        "xarm5": Version(5, 250.0),
    }

    def listen(self, address: str) -> None:
        """Listen on the report ports."""
        host = address or HOST
        self._port = 30003 if self.version.endswith("old") else 30000
        server = partial(TcpServer, self, places=MOST_CLIENTS)
        self._fast = server((host, self._port), channel=str(self._port))
        self._rich = server((host, RICH), channel=str(RICH))
        self._fast.on_join = self._fast.on_leave = self._follow
        self._rich.on_join = self._send_rich
        self.driver_address = f"xarm:{host}"

    def send_state(self, state: JointState, moment: float) -> None:
        """Send a report to whoever listens to the fast port."""
        time = FIRST_TIME + round(self.number * 1e6 / self.arm.rate)
        report = real_report(state)
        if self._port == 30000:
            report = fast_report(time, state)
        self.emit(self._fast.send, report, moment)

    def _follow(self) -> None:
        self.streaming = bool(self._fast.clients)
        if self.streaming:
            self.arm.connect()

    def _send_rich(self) -> None:
        self.arm.connect()
        self._rich.send(rich_report(self.arm.state(0.0)))


def real_report(state: JointState) -> bytes:
    """Return a report of port 30003."""
    torques = _seven(state.effort or ())
    return _report(
        REAL_SIZE,
        {4: bytes([GUIDING]), 7: _seven(state.position), 59: torques},
    )


def fast_report(time: int, state: JointState) -> bytes:
    """Return a report of port 30000, by the controller's time [us]."""
    fields = {
        4: time.to_bytes(8, "big"),
        12: bytes([GUIDING]),
        32: _seven([q + 1e-3 for q in state.position]),  # targets
        116: _seven(state.position),
        228: _seven(state.effort or ()),
    }
    return _report(FAST_SIZE, fields)


def rich_report(state: JointState) -> bytes:
    """Return a report of port 30002."""
    kind = bytes([6, len(state.position), 0xAA, 0x55, 0, 0]) + b"v2.6.0"
    return _report(RICH_SIZE, {4: real_report(state)[4:], NORMAL_SIZE: kind})


def _report(size: int, fields: dict[int, bytes]) -> bytes:
    """Return a report of so many bytes: its size, fields by their first byte, and zeros."""
    report = bytearray(size)
    report[:4] = size.to_bytes(4, "big")
    for first, data in fields.items():
        report[first : first + len(data)] = data
    return bytes(report)


def _seven(values: Sequence[float]) -> bytes:
    return struct.pack(f"<{len(values)}f", *values).ljust(28, b"\0")
