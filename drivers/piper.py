"""AgileX Piper: the joint angles that the arm puts on its CAN bus, overheard.

The arm sends three frames of two joints each, in turn, whatever anybody does. Nothing is sent:
the bus is only listened to. The frames carry no number, so that a missing one is told by its
turn, and a state with one is counted as missed.

Stamps are when the last frame came in, evened out. Efforts are None: these frames have none.

Address: a CAN bus, ``[INTERFACE/]CHANNEL``, see :mod:`mukca.drivers.canbus`; ``can0`` by default.
"""

import math
import struct
from collections.abc import Sequence

import can

from . import clock
from .arrival import EvenStamps
from .canbus import open_bus, parse_can_address
from .driver import Driver, DriverError, JointState, Reason, match_joints

__all__ = ["IDENTIFIERS", "Piper", "decode_frame"]

JOINTS = 6
IDENTIFIERS = (0x2A5, 0x2A6, 0x2A7)  # joints 1 and 2, 3 and 4, 5 and 6
FIRST_STATE_SECONDS = 2.0
PERIOD = 0.005  # s, about
UNIT = math.radians(1e-3)  # thousandths of a degree
LARGEST_COUNT = 360_000
PAIR = struct.Struct(">ii")


def decode_frame(data: bytes) -> tuple[float, float]:
    """Return the two joint angles in a frame [rad].

    Raises:
        ValueError: The wrong length, or an angle beyond a turn.
    """
    if len(data) != PAIR.size:
        raise ValueError(f"a frame of {len(data)} bytes where {PAIR.size} are expected")
    first, second = PAIR.unpack(data)
    if max(abs(first), abs(second)) > LARGEST_COUNT:
        raise ValueError("a frame with impossible joint angles")
    return first * UNIT, second * UNIT


class Piper(Driver):
    """A Piper on a CAN bus."""

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        self._joint_names = match_joints(joint_names, JOINTS, "a Piper")
        bus = parse_can_address(address)
        self._where = str(bus)
        self._angles: list[float] = []
        """Angles of the frames of this turn, as far as they have come."""
        self._lost = True
        """Whether this turn is given up; also before the first."""
        self._stamp = EvenStamps(PERIOD)
        self._pending: JointState | None = None
        self._bus = open_bus(bus, IDENTIFIERS)
        self._open = True
        try:
            self._pending = self.read(FIRST_STATE_SECONDS)
        except DriverError as error:
            self.close()
            raise self._nobody(error) from None

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The arm's six joints, from base to flange."""
        return self._joint_names

    def read(self, timeout: float) -> JointState:
        """Return the next state; see :meth:`Driver.read`."""
        if self._pending is not None:
            state, self._pending = self._pending, None
            return state
        deadline = clock.now() + timeout
        while (frame := self._receive(deadline)) is not None:
            state = self._take(frame)
            if state is not None:
                return state
        raise DriverError(Reason.SILENT, f"no joint angles on {self._where} for {timeout:g} s")

    def close(self) -> None:
        """Leave the bus."""
        if self._open:
            self._open = False
            self._bus.shutdown()

    def _receive(self, deadline: float) -> can.Message | None:
        """Return the next frame with joint angles."""
        if not self._open:
            raise DriverError(Reason.UNREACHABLE, "the connection is closed")
        while True:
            wait = max(0.0, deadline - clock.now())
            try:
                frame = self._bus.recv(wait)
            except (can.CanError, OSError) as error:
                raise DriverError(
                    Reason.UNREACHABLE, f"CAN bus {self._where} is lost: {error}"
                ) from None
            if frame is None:
                return None
            if not (frame.is_extended_id or frame.is_error_frame or frame.is_remote_frame):
                return frame

    def _take(self, frame: can.Message) -> JointState | None:
        """Add a frame to the state of this turn, and return the state if it is whole."""
        turn = IDENTIFIERS.index(frame.arbitration_id)
        try:
            angles = decode_frame(bytes(frame.data))
        except ValueError:
            self.rejected += 1
            self._lose_turn()
            return None
        if turn != len(self._angles) // 2:
            self._lose_turn()
        if turn == 0:
            self._lost = False
        if self._lost:
            return None
        self._angles += angles
        if len(self._angles) < JOINTS:
            return None
        position, self._angles = tuple(self._angles), []
        return JointState(self._stamp(frame.timestamp or clock.now()), position)

    def _lose_turn(self) -> None:
        """Give up the state of this turn, and wait for the first frame of the next."""
        self.missed += not self._lost
        self._lost = True
        self._angles = []

    def _nobody(self, error: DriverError) -> DriverError:
        if error.reason is not Reason.SILENT:
            return error
        return DriverError(
            Reason.UNREACHABLE,
            f"no joint angles on {self._where}: is the arm on, and the bus at 1 Mbit/s?",
        )
