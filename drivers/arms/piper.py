"""AgileX Piper: the joint angles that the arm puts on its CAN bus, overheard; nothing is sent.

A turn of three frames has two joint angles each, and no number: one that is not whole, or not of
one moment, is thrown away and counted as missed. Stamps are times of arrival, evened out.

Address: a CAN bus, see :mod:`..transport.can_bus`; ``can0`` by default.
"""

import math
import struct

import can

from .. import (
    ArrivalTimeFilter,
    JointState,
    ModelNames,
    ValidatingDriver,
    clock,
    match_joints,
    require_angles,
)
from ..transport import CanBus, parse_can_address

JOINTS = 6
IDENTIFIERS = (0x2A5, 0x2A6, 0x2A7)  # joints 1 and 2, 3 and 4, 5 and 6
FIRST_STATE_SECONDS = 2.0
PERIOD = 0.005  # s, about
CLOCK_STEP = (
    1.0  # s: a larger difference means that somebody has set the computer's clock
)
UNIT = math.radians(1e-3)  # thousandths of a degree
LARGEST_COUNT = 360_000
PAIR = struct.Struct(">ii")


def decode_frame(data: bytes) -> tuple[float, float]:
    """Return the two joint angles in a frame [rad]."""
    if len(data) != PAIR.size:
        raise ValueError(f"a frame of {len(data)} bytes where {PAIR.size} are expected")
    first, second = PAIR.unpack(data)
    require_angles((first, second), LARGEST_COUNT, "a frame")
    return first * UNIT, second * UNIT


class Piper(ValidatingDriver):
    """A Piper on a CAN bus."""

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        bus = parse_can_address(address)
        super().__init__(f"the arm on {bus}")
        self._joint_names = match_joints(joint_names, JOINTS, "a Piper")
        self._angles: list[float] = []
        """Angles of the frames of this turn that have come."""
        self._lost = True
        """True while this turn is given up, as the one before the first frame of all is."""
        self._turn_began = 0.0
        self._stamp = ArrivalTimeFilter(PERIOD)
        self._offset = math.nan
        self._bus = CanBus(bus, IDENTIFIERS)
        with self._closed_on_error():
            self._await_first(
                FIRST_STATE_SECONDS, "is the arm on, and the bus at 1 Mbit/s?"
            )

    def _receive(self, deadline: float) -> JointState:
        while frame := self._bus.receive(deadline):
            state = self._take(frame)
            if state:
                return state
        raise self._silence(deadline, "joint angles")

    def _disconnect(self) -> None:
        self._bus.close()

    def _take(self, frame: can.Message) -> JointState | None:
        """Add a frame to the state of this turn; return the state once it is whole."""
        part = IDENTIFIERS.index(frame.arbitration_id)
        arrival = frame.timestamp or clock.now()
        late = abs(arrival - self._turn_began) > self._stamp.period / 2
        if part != len(self._angles) // 2 or (part and late):
            self._lose_turn()
        if part == 0:
            self._lost, self._turn_began = False, arrival
        try:
            angles = decode_frame(bytes(frame.data))
        except ValueError:
            self._lose_turn()
            raise
        if self._lost:
            return None
        self._angles += angles
        if len(self._angles) < JOINTS:
            return None
        position, self._angles = tuple(self._angles), []
        # Buses tell the time of arrival by a clock that is set; the first one is far off, too.
        now = clock.now()
        if not abs(arrival + self._offset - now) < CLOCK_STEP:
            self._offset = now - arrival
        return JointState(self._stamp(arrival + self._offset), position)

    def _lose_turn(self) -> None:
        """Give up the state of this turn, and wait for the first frame of the next."""
        self.missed += not self._lost
        self._lost = True
        self._angles = []
