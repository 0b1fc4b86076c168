"""An OpenArm's Damiao motors, switched off, on a CAN bus.

Shown by hand against the package damiao-motor 1.0.6: its controller reads these answers, and asks
by the same requests.
"""

import struct

from ...drivers import JointState
from .emulator import Emulator, Version
from .ports import CanPort

JOINTS = 7
HALF_RANGE = 12.5  # rad
REST = b"\x7f\xf8\x00\x19\x1b"  # no speed, no torque, 25 and 27 degrees


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
