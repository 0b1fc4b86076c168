"""Kinova Gen2 actuators: each answers when it is asked where it is.

On a pseudo-terminal (a serial line whose settings nobody checks), or behind a gateway that carries
the same messages by ISO-TP on a CAN bus. No client of Kinova's was run against it.
"""

import math
import os
import struct

import can
import isotp

from ...drivers.transport import open_bus, parse_can_address
from .emulator import PolledEmulator, Version
from .piper import DEFAULT_BUS

MESSAGE_BYTES = 20
FIRST_ACTUATOR = 0x10
JOINTS = 6


class KinovaEmulator(PolledEmulator):
    """Six actuators on a line."""

    VERSIONS = dict.fromkeys(("serial", "can"), Version(JOINTS, 1000.0))

    def listen(self, address: str) -> None:
        """Open a pseudo-terminal, or join a CAN bus."""
        self._buffer = b""
        if self.version == "serial":
            self._line, port = self.open_line(address)
            self.driver_address = f"kinova:serial://{port}?parity=none"  # it has none
            self.watch(self._line, self._read_line)
            return
        bus = parse_can_address(address or DEFAULT_BUS)
        self.driver_address = f"kinova:can://{address or DEFAULT_BUS}"
        self._bus = open_bus(bus)
        self.opened.callback(self._bus.shutdown)
        self._transfer = isotp.TransportLayerLogic(
            rxfn=self._receive_frame,
            txfn=self._send_frame,
            address=isotp.Address(isotp.AddressingMode.Normal_11bits, txid=0x701, rxid=0x700),
        )
        self.watch(self._bus.fileno(), self._read_bus)

    def _read_line(self) -> None:
        self._buffer += os.read(self._line, 4096)
        while len(self._buffer) >= MESSAGE_BYTES:
            message, self._buffer = self._buffer[:MESSAGE_BYTES], self._buffer[MESSAGE_BYTES:]
            self.journal.received("line", message)
            for reply in self._replies(message):
                os.write(self._line, reply)

    def _read_bus(self) -> None:
        self._transfer.process()
        while self._transfer.available():
            message = bytes(self._transfer.recv() or b"")
            self.journal.received("line", message)
            for reply in self._replies(message):
                self._transfer.send(reply)
            self._transfer.process()

    def _replies(self, message: bytes) -> list[bytes]:
        """Return what comes back: nothing, unless an actuator was asked for its position."""
        command, _, actuator = struct.unpack_from("<hBB", message)
        joint = actuator - FIRST_ACTUATOR
        if command != 1 or joint not in range(JOINTS):
            return []
        self.begin()
        moment = self.moment
        if self.is_away(moment):
            return []
        state = self.next_state(moment)
        torque = state.effort[joint] if state.effort else 0.0
        values = struct.pack("<4f", 0.0, math.degrees(state.position[joint]), 0.0, torque)
        reply = struct.pack("<hBB", 2, actuator, 0) + values
        return [payload for _, payload in self.packets(reply, moment)]

    def _receive_frame(self, timeout: float) -> isotp.CanMessage | None:
        frame = self._bus.recv(0)
        if frame is None:
            return None
        if frame.arbitration_id not in (0x700, 0x701):
            self.journal.received(f"{frame.arbitration_id:03x}", bytes(frame.data))
        return isotp.CanMessage(arbitration_id=frame.arbitration_id, data=bytes(frame.data))

    def _send_frame(self, frame: isotp.CanMessage) -> None:
        self._bus.send(
            can.Message(arbitration_id=frame.arbitration_id, data=frame.data, is_extended_id=False)
        )
