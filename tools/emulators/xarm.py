"""A UFACTORY controller's report ports; proven against xarm-python-sdk 1.18.4."""

import struct

from ...drivers import JointState
from .emulator import Emulator, Version
from .ports import TcpServer

HOST = "127.0.0.1"
RICH, NORMAL_SIZE, RICH_SIZE = 30002, 145, 233
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
        self._port = 30003 if self.version.endswith("old") else 30000
        self._fast, self._rich = (
            TcpServer(self, (address or HOST, port), channel=str(port), places=MOST_CLIENTS)
            for port in (self._port, RICH)
        )
        self._fast.on_join, self._fast.on_leave = self._follow, self._follow
        self._follow()
        self._rich.on_join = self._send_rich
        self.driver_address = f"xarm:{address or HOST}"

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send a report to whoever listens to the fast port."""
        time = FIRST_TIME + round(number * 1e6 / self.arm.rate)
        report = fast_report(time, state) if self._port == 30000 else real_report(state)
        self.emit(self._fast.send, report, moment)

    def _follow(self) -> None:
        self.streaming = bool(self._fast.clients)
        if self.streaming:
            self.begin()

    def _send_rich(self) -> None:
        self.begin()
        self._rich.send(rich_report(self.arm.state(0.0)))


def real_report(state: JointState) -> bytes:
    """Return a report of port 30003."""
    torques = _seven(state.effort or (0.0,) * len(state.position))
    body = bytes([GUIDING]) + bytes(2) + _seven(state.position) + bytes(24) + torques
    return (len(body) + 4).to_bytes(4, "big") + body


def fast_report(time: int, state: JointState) -> bytes:
    """Return a report of port 30000, by the controller's time [us]."""
    head = time.to_bytes(8, "big") + bytes([GUIDING]) + bytes(2 + 17)
    still = bytes(28)
    targets = _seven(tuple(q + 1e-3 for q in state.position)) + still + still
    actual = _seven(state.position) + still + still
    torques = still + _seven(state.effort or (0.0,) * len(state.position))
    body = head + targets + actual + torques
    body += bytes(804 - 4 - len(body))
    return (804).to_bytes(4, "big") + body


def rich_report(state: JointState) -> bytes:
    """Return a report of port 30002."""
    body = real_report(state)[4:]
    body += bytes(NORMAL_SIZE - 4 - len(body))
    body += bytes([6, len(state.position), 0xAA, 0x55]) + bytes(2) + b"v2.6.0".ljust(30, b"\0")
    body += bytes(RICH_SIZE - 4 - len(body))
    return RICH_SIZE.to_bytes(4, "big") + body


def _seven(values: tuple[float, ...]) -> bytes:
    return struct.pack("<7f", *values, *[0.0] * (7 - len(values)))
