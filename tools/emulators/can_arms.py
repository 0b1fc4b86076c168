"""Arms on a CAN bus: an OpenArm's Damiao motors, switched off, and AgileX' Piper.

damiao-motor 1.0.6 reads and asks the motors (shown by hand), piper_sdk 0.6.2 reads the Piper.
"""

import math
import struct
from collections import Counter

from ...drivers import JointState
from .emulator import Emulator, Version
from .ports import CanPort

JOINTS = 7
HALF_RANGE = 12.5  # rad
REST = b"\x7f\xf8\x00\x19\x1b"  # no speed, no torque, 25 and 27 degrees
PIPER_FRAMES = (0x2A5, 0x2A6, 0x2A7)


class DamiaoEmulator(Emulator):
    """Seven motors that answer when they are asked."""

    POLLED = True
    VERSIONS = {"openarm": Version(JOINTS, 1000.0)}  # noqa: RUF012
    status = 0
    """Status of every motor: 0 off, 1 enabled, others an alarm."""
    pmax = HALF_RANGE
    """PMAX that every motor tells [rad]."""

    def listen(self, address: str) -> None:
        """Join the bus."""
        self._bus = CanPort(self, address, self._overhear)
        self.driver_address = f"damiao:{self._bus.address}"
        self._state: JointState | None = None

    def _overhear(self, identifier: int, data: bytes) -> None:
        if 0x11 <= identifier <= 0x17:  # our own come back
            return
        self.journal.received(f"{identifier:03x}", data)
        if identifier != 0x7FF or len(data) != 8 or not 1 <= data[0] <= JOINTS:
            return
        motor = data[0]
        self.begin()
        if data[2:4] == b"\x33\x15":
            reply = data[:4] + struct.pack("<f", self.pmax)
        elif data[2] == 0xCC:
            if motor == 1 or self._state is None:
                self._state = self.next_state(self.moment)
            count = round((self._state.position[motor - 1] + HALF_RANGE) / 25 * 65535)
            reply = bytes([self.status << 4 | motor]) + count.to_bytes(2, "big") + REST
        else:
            return
        self.answer(self._bus.send, reply, 0x10 + motor)


class PiperEmulator(Emulator):
    """A Piper that sends its joint angles, whoever listens."""

    VERSIONS = {"1": Version(6, 200.0)}  # noqa: RUF012

    def listen(self, address: str) -> None:
        """Join the bus; every frame of anybody else is noted."""
        self._bus = CanPort(self, address, self._overhear)
        self.driver_address = f"piper:{self._bus.address}"
        self._own: Counter[tuple[int, bytes]] = Counter()
        self.begin()

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send the three frames of one state."""
        counts = [round(math.degrees(angle) * 1000) for angle in state.position]
        for index, identifier in enumerate(PIPER_FRAMES):
            pair = struct.pack(">ii", *counts[2 * index : 2 * index + 2])
            self.emit(self._send, pair, moment, identifier)

    def _send(self, data: bytes, identifier: int) -> None:
        self._own[identifier, data] += 1
        self._bus.send(data, identifier)

    def _overhear(self, identifier: int, data: bytes) -> None:
        """Note a frame, unless it is one of ours that the bus brings back."""
        if self._own[identifier, data] > 0:
            self._own[identifier, data] -= 1
        else:
            self.journal.received(f"{identifier:03x}", data)
