"""An OpenArm's Damiao motors, switched off, on a CAN bus.

Shown by hand against the package damiao-motor 1.0.6: its controller reads these answers, and asks
by the same requests.
"""

import struct

import can

from ...drivers import JointState
from ...drivers.transport import open_bus, parse_can_address
from .emulator import PolledEmulator, Version
from .piper import DEFAULT_BUS

JOINTS = 7
HALF_RANGE = 12.5  # rad
REST = b"\x7f\xf8\x00\x19\x1b"  # no speed, no torque, 25 and 27 degrees


class DamiaoEmulator(PolledEmulator):
    """Seven motors that answer when they are asked."""

    VERSIONS = {"openarm": Version(JOINTS, 1000.0)}  # noqa: RUF012
    status = 0
    """Status of every motor: 0 off, 1 enabled, others an alarm."""
    pmax = HALF_RANGE
    """PMAX that every motor tells [rad]."""

    def listen(self, address: str) -> None:
        """Join the bus."""
        address = address or DEFAULT_BUS
        self.driver_address = f"damiao:{address}"
        self._bus = open_bus(parse_can_address(address))
        self.opened.callback(self._bus.shutdown)
        self._state: JointState | None = None
        self.watch(self._bus.fileno(), self._overhear)

    def _overhear(self) -> None:
        frame = self._bus.recv(0)
        if frame is None or 0x11 <= frame.arbitration_id <= 0x17:  # our own come back
            return
        data = bytes(frame.data)
        self.journal.received(f"{frame.arbitration_id:03x}", data)
        motor = data[0]
        if frame.arbitration_id != 0x7FF or len(data) != 8 or not 1 <= motor <= JOINTS:
            return
        self.begin()
        moment = self.moment
        if self.is_away(moment):
            return
        if data[2:4] == b"\x33\x15":
            self._answer(motor, data[:4] + struct.pack("<f", self.pmax), moment)
        elif data[2] == 0xCC:
            if motor == 1 or self._state is None:
                self._state = self.next_state(moment)
            count = round((self._state.position[motor - 1] + HALF_RANGE) / 25 * 65535)
            head = bytes([self.status << 4 | motor]) + count.to_bytes(2, "big")
            self._answer(motor, head + REST, moment)

    def _answer(self, motor: int, data: bytes, moment: float) -> None:
        for sent_as, packet in self.packets(data, moment, 0x10 + motor):
            self._bus.send(can.Message(arbitration_id=sent_as, data=packet, is_extended_id=False))
