"""Arms on a CAN bus: Damiao motors, switched off, AgileX' Piper, and Kinova's actuators.

damiao-motor 1.0.6 reads and asks the motors (shown by hand), piper_sdk 0.6.2 reads the Piper. No
client of Kinova's was run against its actuators, on a pseudo-terminal, or by ISO-TP on a bus.
"""

import math
import struct
from collections import deque
from collections.abc import Callable
from typing import Any

from ...drivers import JointState
from .emulator import Emulator, Version
from .ports import CanPort, SerialPort

JOINTS = 7
HALF_RANGE = 12.5  # rad
REST = b"\x7f\xf8\x00\x19\x1b"  # no speed, no torque, 25 and 27 degrees
PIPER_FRAMES = (0x2A5, 0x2A6, 0x2A7)


class DamiaoEmulator(Emulator):
    """Seven motors that answer when they are asked."""

    VERSIONS = {"openarm": Version(JOINTS, 1000.0)}  # noqa: RUF012
    status = 0
    """Status of every motor: 0 off, 1 enabled, others an alarm."""
    pmax = HALF_RANGE
    """PMAX that every motor tells [rad]."""
    first_serial = 20_260_000
    """Serial number before that of the first motor."""

    def listen(self, address: str) -> None:
        """Join the bus."""
        self._bus = CanPort(self, address, self._reply)
        self.driver_address = f"damiao:{self._bus.address}"
        self._state: JointState | None = None

    def _reply(self, identifier: int, data: bytes) -> None:
        motor = data[0] if identifier == 0x7FF and len(data) == 8 else 0
        if not 1 <= motor <= JOINTS:
            return
        self.arm.connect()
        if data[2:4] == b"\x33\x15":
            reply = data[:4] + struct.pack("<f", self.pmax)
        elif data[2:4] == b"\x33\x0f":
            reply = data[:4] + struct.pack("<I", self.first_serial + motor)
        elif data[2] == 0xCC:
            if motor == 1 or self._state is None:
                self._state = self.next_state(self.moment)
            angle = self._state.position[motor - 1]
            count = round((angle + HALF_RANGE) / 25 * 65535)
            reply = bytes([self.status << 4 | motor]) + count.to_bytes(2, "big") + REST
        else:
            return
        self.answer(self._bus.send, reply, 0x10 + motor)


class PiperEmulator(Emulator):
    """A Piper that sends its joint angles, whoever listens."""

    VERSIONS = {"1": Version(6, 200.0)}  # noqa: RUF012

    def listen(self, address: str) -> None:
        """Join the bus."""
        self._bus = CanPort(self, address)
        self.driver_address = f"piper:{self._bus.address}"
        self.streaming = True
        self.arm.connect()

    def send_state(self, state: JointState, moment: float) -> None:
        """Send the three frames of one state."""
        counts = [round(1000 * angle) for angle in map(math.degrees, state.position)]
        for identifier, first in zip(PIPER_FRAMES, (0, 2, 4), strict=True):
            pair = struct.pack(">ii", *counts[first : first + 2])
            self.emit(self._bus.send, pair, moment, identifier)


MESSAGE_BYTES = 20
FIRST_ACTUATOR = 0x10
REQUESTS, ANSWERS = 0x700, 0x701
ACTUATORS = 6


class KinovaEmulator(Emulator):
    """Six actuators on a line."""

    VERSIONS = dict.fromkeys(("serial", "can"), Version(ACTUATORS, 1000.0))

    def listen(self, address: str) -> None:
        """Open a pseudo-terminal, or join a CAN bus."""
        if self.version == "serial":
            line = SerialPort(self, address, self._receive)
            self._send: Callable[[bytes, Any], None] = line.send
            self.driver_address = (
                f"kinova:serial://{line.name}?parity=none"  # it has none
            )
            return
        import isotp

        self._bus = CanPort(self, address, self._receive_frame)
        self.driver_address = f"kinova:can://{self._bus.address}"
        self._frame, self._frames = isotp.CanMessage, deque[isotp.CanMessage]()
        self._transfer = isotp.TransportLayerLogic(
            rxfn=lambda _: self._frames.popleft() if self._frames else None,
            txfn=lambda frame: self._bus.send(bytes(frame.data), ANSWERS),
            address=isotp.Address(
                isotp.AddressingMode.Normal_11bits,
                txid=ANSWERS,
                rxid=REQUESTS,
            ),
        )
        self._send = lambda message, _: self._transfer.send(message)

    def _receive(self, received: bytearray) -> None:
        while len(received) >= MESSAGE_BYTES:
            self._reply(bytes(received[:MESSAGE_BYTES]))
            del received[:MESSAGE_BYTES]

    def _receive_frame(self, identifier: int, data: bytes) -> None:
        self._frames.append(self._frame(arbitration_id=identifier, data=data))
        self._transfer.process()
        while self._transfer.available():
            message = bytes(self._transfer.recv() or b"")
            self.journal.received("can", message)
            self._reply(message)
            self._transfer.process()

    def _reply(self, message: bytes) -> None:
        """Answer a request of an actuator's position, and nothing else."""
        if len(message) != MESSAGE_BYTES:
            return
        command, _, actuator = struct.unpack_from("<hBB", message)
        joint = actuator - FIRST_ACTUATOR
        if command != 1 or joint not in range(ACTUATORS):
            return
        self.arm.connect()
        state = self.next_state(self.moment)
        degrees = math.degrees(state.position[joint])
        torque = state.effort[joint] if state.effort else 0.0
        values = struct.pack("<4f", 0.0, degrees, 0.0, torque)
        header = struct.pack("<hBB", 2, actuator, 0)
        self.answer(self._send, header + values)
