"""Universal Robots, CB3 and e-series, UR3 to UR20: RTDE, outputs only.

A package is u16 size (all of it) | u8 type | payload, big-endian. Four requests are sent: versions
of protocol and controller, which outputs and how often, and to start; none is an input. Efforts are
None, since these arms measure currents; ``effort=OUTPUT`` asks for an output of six numbers, as
``target_moment``, which the controller's model computes. Signs were not proven.

Address: ``HOST[:PORT][?rate=HZ&effort=OUTPUT]``.
"""

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from .. import (
    DriverError,
    JointState,
    JointValues,
    ModelNames,
    Reason,
    ValidatingDriver,
    clock,
    match_joints,
    require_angles,
    require_finite,
)
from ..transport import CONNECT_SECONDS, TcpStream, cut, parse_endpoint

PORT = 30004
JOINTS = 6
E_SERIES = 5  # first major version of its software
TRIED = "software 3.15, 5.11 and 10.7 was tried"
SLOW, FAST = 125, 500  # Hz, of a CB3 and of an e-series controller


TYPES = b"VvOSUMP"  # the last two are texts and pauses
PROTOCOL_VERSION, CONTROLLER_VERSION, SETUP_OUTPUTS, START, DATA = TYPES[:5]

HEADER = struct.Struct(">HB")
LARGEST_PACKAGE = 4096
LARGEST_ANGLE = 4 * math.pi  # these joints turn once to each side
LARGEST_MODE = (
    99  # modes are small numbers, and newer software has some that have no name here
)

_ROBOT_MODES = (
    "no controller, disconnected, confirm safety, booting, power off, power on, idle, backdrive, "
    "running, updating firmware"
)
_SAFETY_MODES = (
    "normal, reduced, protective stop, recovery, safeguard stop, system emergency stop, robot "
    "emergency stop, violation, fault"
)
ROBOT_MODES = dict(enumerate(_ROBOT_MODES.split(", "), -1))
SAFETY_MODES = dict(enumerate(_SAFETY_MODES.split(", "), 1))
OUTPUTS = {
    "timestamp": "DOUBLE",
    "actual_q": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_mode": "INT32",
}
PLAIN = struct.Struct(">Bd6dii")
WITH_EFFORT = struct.Struct(">Bd6dii6d")


class Ur(ValidatingDriver):
    """A UR arm that streams its state."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        endpoint = parse_endpoint(address, PORT, options=("rate", "effort"))
        super().__init__(f"the robot at {endpoint}")
        self._joint_names = match_joints(joint_names, JOINTS, "a UR arm")
        wanted_rate = endpoint.options.positive("rate", FAST)
        self._tcp = TcpStream(endpoint, "is the robot's controller started?")
        with self._closed_on_error():
            self.rate = min(wanted_rate, self._fastest())
            """States per second."""
            self._period = 1 / self.rate
            effort = endpoint.options.get("effort")
            outputs = self._ask(SETUP_OUTPUTS, setup_payload(self.rate, effort))
            try:
                self._recipe = decode_recipe(outputs, effort)
            except ValueError as error:
                raise Reason.PROTOCOL(f"{self._where} sends {error}") from None
            if self._ask(START) != b"\x01":
                raise Reason.WRONG_MODE(f"{self._where} refuses to start")

    def _receive(self, deadline: float) -> JointState:
        state, self.status = self._recipe.decode(self._next_package(DATA, deadline))
        return state

    def _disconnect(self) -> None:
        self._tcp.close()

    def _fastest(self) -> int:
        """Agree on the protocol; return the greatest rate of this controller [Hz]."""
        if self._ask(PROTOCOL_VERSION, struct.pack(">H", 2)) != b"\x01":
            raise Reason.PROTOCOL(
                f"{self._where} does not speak RTDE version 2: {TRIED}"
            )
        version = self._ask(CONTROLLER_VERSION)
        if len(version) != 16:
            raise Reason.PROTOCOL(
                f"{self._where} sends no version that can be read: {TRIED}"
            )
        numbers = struct.unpack(">4I", version)
        self.identity = f"version {'.'.join(map(str, numbers))}"
        return FAST if numbers[0] >= E_SERIES else SLOW

    def _ask(self, kind: int, payload: bytes = b"") -> bytes:
        """Send a request and return the payload of its reply."""
        try:
            self._tcp.send(encode_package(kind, payload))
            return self._next_package(kind, clock.now() + CONNECT_SECONDS)
        except DriverError as error:
            if error.reason is Reason.PROTOCOL:
                raise
            raise Reason.BUSY(
                f"{self._where} took the connection but did not answer: is RTDE switched on, "
                "and does another program use all of its connections?"
            ) from None

    def _next_package(self, kind: int, deadline: float) -> bytes:
        """Return the payload of the next package of a type; others, as texts, are left out."""
        while True:
            came, payload = self._tcp.take(take_package, deadline)
            if came == kind:
                return payload
            if clock.now() > deadline:
                raise Reason.SILENT(f"no state from {self._where}, but other packages")


@dataclass(frozen=True)
class Recipe:
    """Outputs of a data package, under the number that the controller gave them."""

    number: int
    effort: bool

    def decode(self, payload: bytes) -> tuple[JointState, str]:
        """Return the state in a data package, and the modes in words."""
        layout = WITH_EFFORT if self.effort else PLAIN
        if len(payload) != layout.size or payload[0] != self.number:
            raise ValueError(
                f"a data package of {len(payload)} bytes that nobody asked for"
            )
        _, timestamp, *values = layout.unpack(payload)
        position, effort = tuple(values[:6]), tuple(values[8:]) or None
        require_finite((timestamp, *(effort or ())), "a data package with values")
        if not all(-1 <= mode <= LARGEST_MODE for mode in values[6:8]):
            raise ValueError("a data package with an impossible mode")
        state = JointState(timestamp, check_angles(position), effort)
        return state, status_text(*values[6:8])


def check_angles(position: Sequence[float]) -> JointValues:
    """Return six joint angles [rad], if they can be."""
    *arm, wrist_3 = position
    if not math.isfinite(wrist_3):
        arm.append(wrist_3)
    require_angles(arm, LARGEST_ANGLE, "a data package")
    return tuple(position)


def status_text(robot_mode: int, safety_mode: int) -> str:
    """Return the names of two modes."""
    robot = ROBOT_MODES.get(robot_mode, f"robot mode {robot_mode}")
    return f"{robot}, {SAFETY_MODES.get(safety_mode, f'safety mode {safety_mode}')}"


def encode_package(kind: int, payload: bytes = b"") -> bytes:
    """Return a package."""
    return HEADER.pack(HEADER.size + len(payload), kind) + payload


def setup_payload(frequency: float, effort: str | None) -> bytes:
    """Return the request for outputs, at a rate [Hz], with one more for the efforts [N m]."""
    names = [*OUTPUTS, *([effort] if effort else [])]
    return struct.pack(">d", frequency) + ",".join(names).encode()


def decode_recipe(payload: bytes, effort: str | None) -> Recipe:
    """Return the recipe that the controller made of a request."""
    types = payload[1:].decode("ascii", "replace").rstrip(",").split(",")
    outputs = {**OUTPUTS, **({effort: "VECTOR6D"} if effort else {})}
    if len(payload) < 1 or len(types) != len(outputs):
        raise ValueError(f"{len(types)} outputs where {len(outputs)} were asked for")
    for (name, kind), got in zip(outputs.items(), types, strict=True):
        if got == "NOT_FOUND":
            raise ValueError(f"no output called {name}: its software does not have it")
        if got != kind:
            raise ValueError(f"output {name} is {got}, not {kind}")
    return Recipe(payload[0], effort is not None)


def take_package(stream: bytearray) -> tuple[int, bytes] | None:
    """Take the first package off a stream and return its type and payload; None if incomplete."""
    if len(stream) < HEADER.size:
        return None
    size, kind = HEADER.unpack_from(stream)
    if kind not in TYPES or not HEADER.size <= size <= LARGEST_PACKAGE:
        raise ValueError(f"a package of type {kind} and {size} bytes")
    package = cut(stream, size)
    return None if package is None else (kind, package[HEADER.size :])
