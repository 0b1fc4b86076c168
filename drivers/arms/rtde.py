"""Universal Robots' RTDE packages: a stream of them, big-endian, each of a size and a type.

::

    u16 size (with these three bytes) | u8 type | payload

What is sent to the controller is four requests: the protocol's version, the controller's
version, which outputs to send and how often, and to start. None of them is an input.
"""

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from .. import JointState

TYPES = b"VvOSUMP"  # the last two are texts and pauses
PROTOCOL_VERSION, CONTROLLER_VERSION, SETUP_OUTPUTS, START, DATA = TYPES[:5]

HEADER = struct.Struct(">HB")
LARGEST_PACKAGE = 4096
LARGEST_ANGLE = 4 * math.pi  # these joints turn once to each side
LARGEST_MODE = 99  # modes are small numbers, and newer software has some that have no name here

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


@dataclass(frozen=True)
class Recipe:
    """Outputs of a data package, under the number that the controller gave them."""

    number: int
    effort: bool

    def decode(self, payload: bytes) -> tuple[JointState, str]:
        """Return the state in a data package, and the modes in words."""
        layout = WITH_EFFORT if self.effort else PLAIN
        if len(payload) != layout.size or payload[0] != self.number:
            raise ValueError(f"a data package of {len(payload)} bytes that nobody asked for")
        _, timestamp, *rest = layout.unpack(payload)
        position, effort = tuple(rest[:6]), tuple(rest[8:]) or None
        if not all(map(math.isfinite, (timestamp, *(effort or ())))):
            raise ValueError("a data package with values that are no numbers")
        if not all(-1 <= mode <= LARGEST_MODE for mode in rest[6:8]):
            raise ValueError("a data package with an impossible mode")
        state = JointState(timestamp, check_angles(position), effort)
        return state, status_text(*rest[6:8])


PLAIN = struct.Struct(">Bd6dii")
WITH_EFFORT = struct.Struct(">Bd6dii6d")


def check_angles(position: Sequence[float]) -> tuple[float, ...]:
    """Return six joint angles [rad], if they can be."""
    *arm, wrist_3 = position
    if not all(abs(angle) <= LARGEST_ANGLE for angle in arm) or not math.isfinite(wrist_3):
        raise ValueError("a data package with impossible joint angles")
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
    given = payload[1:].decode("ascii", "replace").rstrip(",").split(",")
    wanted = {**OUTPUTS, **({effort: "VECTOR6D"} if effort else {})}
    if len(payload) < 1 or len(given) != len(wanted):
        raise ValueError(f"{len(given)} outputs where {len(wanted)} were asked for")
    for (name, kind), got in zip(wanted.items(), given, strict=True):
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
    if len(stream) < size:
        return None
    payload = bytes(stream[HEADER.size : size])
    del stream[:size]
    return kind, payload
