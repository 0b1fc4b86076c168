"""Kinova Gen2 actuators, on a pseudo-terminal, or by ISO-TP behind a gateway on a CAN bus.

No client of Kinova's was run against it.
"""

import math
import struct
from collections import deque
from collections.abc import Callable
from typing import Any

import isotp

from .emulator import Emulator, Version
from .ports import CanPort, SerialPort

MESSAGE_BYTES = 20
FIRST_ACTUATOR = 0x10
REQUESTS, ANSWERS = 0x700, 0x701
JOINTS = 6


class KinovaEmulator(Emulator):
    """Six actuators on a line."""

    POLLED = True
    VERSIONS = dict.fromkeys(("serial", "can"), Version(JOINTS, 1000.0))

    def listen(self, address: str) -> None:
        """Open a pseudo-terminal, or join a CAN bus."""
        if self.version == "serial":
            line = SerialPort(self, address, self._hear)
            self._send: Callable[[bytes, Any], None] = line.send
            self.driver_address = f"kinova:serial://{line.name}?parity=none"  # it has none
            return
        self._bus = CanPort(self, address, self._hear_frame)
        self.driver_address = f"kinova:can://{self._bus.address}"
        self._frames: deque[isotp.CanMessage] = deque()
        self._transfer = isotp.TransportLayerLogic(
            rxfn=lambda _: self._frames.popleft() if self._frames else None,
            txfn=lambda frame: self._bus.send(bytes(frame.data), ANSWERS),
            address=isotp.Address(isotp.AddressingMode.Normal_11bits, txid=ANSWERS, rxid=REQUESTS),
        )
        self._send = lambda message, _: self._transfer.send(message)

    def _hear(self, received: bytearray) -> None:
        while len(received) >= MESSAGE_BYTES:
            self._reply(bytes(received[:MESSAGE_BYTES]))
            del received[:MESSAGE_BYTES]

    def _hear_frame(self, identifier: int, data: bytes) -> None:
        if identifier not in (REQUESTS, ANSWERS):
            self.journal.received(f"{identifier:03x}", data)
        self._frames.append(isotp.CanMessage(arbitration_id=identifier, data=data))
        self._transfer.process()
        while self._transfer.available():
            self._reply(bytes(self._transfer.recv() or b""))
            self._transfer.process()

    def _reply(self, message: bytes) -> None:
        """Answer a request of an actuator's position, and nothing else."""
        self.journal.received("line", message)
        if len(message) != MESSAGE_BYTES:
            return
        command, _, actuator = struct.unpack_from("<hBB", message)
        joint = actuator - FIRST_ACTUATOR
        if command != 1 or joint not in range(JOINTS):
            return
        self.begin()
        state = self.next_state(self.moment)
        torque = state.effort[joint] if state.effort else 0.0
        values = struct.pack("<4f", 0.0, math.degrees(state.position[joint]), 0.0, torque)
        self.answer(self._send, struct.pack("<hBB", 2, actuator, 0) + values)
