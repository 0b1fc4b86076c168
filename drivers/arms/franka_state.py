"""Franka's RobotState datagrams, little-endian: joint angles, torques, mode and errors.

::

    bytes  server versions   robots                    numbers   errors
    2085   3                 Panda, system 3.0         float64   37
    2341   4                 Panda, system 4.0         float64   37
    2373   5 to 9            Panda 4.2, FR3 to 5.7     float64   41
    1377   10                FR3 from 5.9              float32   41
"""

import math
import struct
from dataclasses import dataclass
from typing import Any, cast

from .. import JointState

JOINTS = 7
PERIOD = 1e-3  # s
LARGEST_ANGLE = 2 * math.pi  # no joint of these arms turns further

_MODES = "other, idle, move, guiding, reflex, user stopped, automatic error recovery"

# In the order of the flags, as libfranka names them; where there are 37, the last four lack.
_ERRORS = (
    "joint position limits violation, cartesian position limits violation, self collision "
    "avoidance violation, joint velocity violation, cartesian velocity violation, force control "
    "safety violation, joint reflex, cartesian reflex, max goal pose deviation violation, max path "
    "pose deviation violation, cartesian velocity profile safety violation, joint position motion "
    "generator start pose invalid, joint motion generator position limits violation, joint motion "
    "generator velocity limits violation, joint motion generator velocity discontinuity, joint "
    "motion generator acceleration discontinuity, cartesian position motion generator start pose "
    "invalid, cartesian motion generator elbow limit violation, cartesian motion generator "
    "velocity limits violation, cartesian motion generator velocity discontinuity, cartesian "
    "motion generator acceleration discontinuity, cartesian motion generator elbow sign "
    "inconsistent, cartesian motion generator start elbow invalid, force controller desired force "
    "tolerance violation, start elbow sign inconsistent, communication constraints violation, "
    "power limit violation, cartesian motion generator joint position limits violation, cartesian "
    "motion generator joint velocity limits violation, cartesian motion generator joint velocity "
    "discontinuity, cartesian motion generator joint acceleration discontinuity, cartesian "
    "position motion generator invalid frame, controller torque discontinuity, joint p2p "
    "insufficient torque for planning, tau j range violation, instability detected, joint move in "
    "wrong direction, cartesian spline motion generator violation, joint via motion generator "
    "planning joint limit violation, base acceleration initialization timeout, base acceleration "
    "invalid reading"
)


@dataclass(frozen=True)
class Layout:
    """Offsets in a RobotState of one length [bytes], as in the headers of libfranka-common."""

    number: str
    """Format letter of its numbers: ``d`` or ``f``."""
    torque: int
    position: int
    errors: int
    """Offset of the flags of the current errors; those of the last motion follow."""
    error_count: int

    @property
    def mode(self) -> int:
        """Offset of robot_mode; the command success rate follows."""
        return self.errors + 2 * self.error_count

    @property
    def length(self) -> int:
        """Length of the whole datagram."""
        return self.mode + 1 + struct.calcsize(self.number)

    def compiled(self) -> struct.Struct:
        """Return the structure of message_id, tau_J, q, both groups of flags, mode and rate."""
        size = JOINTS * struct.calcsize(self.number)
        return struct.Struct(
            f"<Q{self.torque - 8}x{JOINTS}{self.number}"
            f"{self.position - self.torque - size}x{JOINTS}{self.number}"
            f"{self.errors - self.position - size}x"
            f"{self.error_count}s{self.error_count}sB{self.number}"
        )


LAYOUTS: dict[int, struct.Struct] = {
    layout.length: layout.compiled()
    for layout in (
        Layout("d", torque=760, position=928, errors=2002, error_count=37),
        Layout("d", torque=1016, position=1184, errors=2258, error_count=37),
        Layout("d", torque=1016, position=1184, errors=2282, error_count=41),
        Layout("f", torque=512, position=596, errors=1290, error_count=41),
    )
}


def decode_state(datagram: bytes) -> tuple[JointState, str]:
    """Return the state in a RobotState datagram, and mode and errors in words."""
    layout = LAYOUTS.get(len(datagram))
    if layout is None:
        raise ValueError(
            f"a datagram of {len(datagram)} bytes is no robot state that is known here "
            f"(they have {', '.join(map(str, LAYOUTS))})"
        )
    fields: tuple[Any, ...] = layout.unpack(datagram)
    torque, position = fields[1:8], fields[8:15]
    current, reflex, mode, rate = cast("tuple[bytes, bytes, int, float]", fields[15:])
    modes = _MODES.split(", ")
    if mode >= len(modes) or (current + reflex).strip(b"\x00\x01") or not 0 <= rate <= 1:
        raise ValueError("a robot state with an unknown mode, error flag or success rate")
    if not all(abs(angle) <= LARGEST_ANGLE for angle in position):  # false for NaN too
        raise ValueError("a robot state with impossible joint angles")
    if not all(map(math.isfinite, torque)):
        raise ValueError("a robot state with torques that are no numbers")
    errors = [name for name, flag in zip(_ERRORS.split(", "), current, strict=False) if flag]
    return JointState(fields[0] * PERIOD, position, torque), "; ".join([modes[mode], *errors])
