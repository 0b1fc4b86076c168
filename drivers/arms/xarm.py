"""UFACTORY xArm 5, 6, 7, Lite 6 and 850: the controller's report stream; nothing is sent.

One report is read from port 30002 (5 Hz, with the number of joints), then 30000 is followed (250 Hz
with its time; newer software alone), else 30003 (100 Hz). Efforts are None: the torques hold an
unknown share of gravity. Address: ``HOST[?port=30003]``.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace

from .. import (
    ArrivalTimeFilter,
    DriverError,
    JointState,
    JointValues,
    ModelNames,
    Reason,
    ValidatingDriver,
    clock,
    match_joints,
    require_angles,
)
from ..transport import Endpoint, TcpStream, cut, parse_endpoint

LARGEST_ANGLE = 6.4
"""No joint turns farther than 360 degrees from its zero, and little more [rad]."""
SHORTEST, LONGEST = 87, 2048  # bytes of a report
FIRST_SECONDS = 2.0
ANGLES = struct.Struct("<7f")
MODES = {
    0: "position control",
    1: "servo motion",
    2: "joint teaching",
    4: "joint velocity",
}
STATES = {1: "moving", 2: "ready", 3: "paused", 4: "stopped"}


@dataclass(frozen=True)
class Layout:
    """Offsets in a report [bytes]."""

    status: int
    """Of the byte with mode and state."""
    angles: int
    time: int | None = None
    """Of the time [us]."""


FAST = Layout(status=12, angles=116, time=4)
REAL = Layout(status=4, angles=7)
PORTS = {30000: FAST, 30003: REAL}
RICH_PORT = 30002
TYPE, JOINTS, SOFTWARE = 145, 146, slice(151, 180)  # in a report of that port


@dataclass(frozen=True, slots=True)
class Report:
    """The used part of a report."""

    angles: JointValues
    """Of seven joints [rad]; an arm with fewer has zeros for the rest."""
    status: str
    time: float | None = None
    """[s]."""


def take_report(received: bytearray) -> bytes | None:
    """Take a report off the front of a stream: it begins with its size."""
    if len(received) < 4:
        return None
    size = int.from_bytes(received[:4], "big")
    if not SHORTEST <= size <= LONGEST:
        raise ValueError(f"a report of {size} bytes, which is none")
    return cut(received, size)


def decode_report(report: bytes, layout: Layout) -> Report:
    """Decode a report."""
    last = max(layout.angles + ANGLES.size, SHORTEST)
    if len(report) < last or int.from_bytes(report[:4], "big") != len(report):
        raise ValueError(f"a report of {len(report)} bytes")
    angles: JointValues = ANGLES.unpack_from(report, layout.angles)
    require_angles(angles, LARGEST_ANGLE, "a report")
    mode, state = divmod(report[layout.status], 16)
    status = f"{MODES.get(mode, f'mode {mode}')}, {STATES.get(state, f'state {state}')}"
    time = None
    if layout.time is not None:
        (count,) = struct.unpack_from(">Q", report, layout.time)
        time = count * 1e-6
    return Report(angles, status, time)


def decode_arm(report: bytes) -> tuple[int, str]:
    """Return an arm's number of joints, and its type and software in words."""
    decode_report(report, REAL)
    joints = report[JOINTS] if len(report) > JOINTS else 0
    if joints not in (5, 6, 7):
        raise ValueError(f"a report of an arm with {joints} joints")
    software = report[SOFTWARE].partition(b"\0")[0].decode("ascii", "replace")
    return joints, f"type {report[TYPE]}, software {software}"


class XArm(ValidatingDriver):
    """A UFACTORY arm that streams its reports."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        endpoint = parse_endpoint(address, RICH_PORT, options=("port",))
        super().__init__(f"the robot at {endpoint.host}")
        port = endpoint.options.integer("port", 0)
        if port not in (0, *PORTS):
            raise endpoint.options.wrong("port", f"one of {', '.join(map(str, PORTS))}")
        tcp = TcpStream(endpoint, "is the controller on, and is this its address?")
        try:
            report = tcp.take(take_report, clock.now() + FIRST_SECONDS)
            count, self.identity = decode_arm(report)
        except ValueError as error:
            raise Reason.PROTOCOL(f"{self._where} sends {error}") from None
        finally:
            tcp.close()
        self._joint_names = match_joints(
            joint_names, count, f"the arm at {endpoint.host}"
        )
        self._even = ArrivalTimeFilter(0.01)
        self._tcp, self._layout = self._follow(
            endpoint, [port] if port else list(PORTS)
        )

    def _receive(self, deadline: float) -> JointState:
        report = decode_report(self._tcp.take(take_report, deadline), self._layout)
        count = len(self._joint_names)
        if any(report.angles[count:]):
            raise ValueError(f"a report with more than {count} joints")
        self.status = report.status
        stamp = self._even(clock.now()) if report.time is None else report.time
        return JointState(stamp, report.angles[:count])

    def _disconnect(self) -> None:
        self._tcp.close()

    def _follow(
        self, endpoint: Endpoint, ports: Sequence[int]
    ) -> tuple[TcpStream, Layout]:
        """Connect to the first of some ports that is there."""
        port, *others = ports
        where = replace(endpoint, port=port)
        try:
            return TcpStream(where, "its software may be too old for this port"), PORTS[
                port
            ]
        except DriverError:
            if not others:
                raise
            return self._follow(endpoint, others)
