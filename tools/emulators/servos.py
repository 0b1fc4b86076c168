"""Servos on a pseudo-terminal: registers that are read, and an arm behind them.

Proven against dynamixel_sdk 4.1.0 and feetech-servo-sdk 1.0.0, which ping and read them.
"""

import struct
from abc import abstractmethod
from typing import Any, ClassVar

from ...drivers.arms.servos import crc16
from ...errors import read_beside
from .emulator import Emulator, Version
from .ports import SerialPort

Request = tuple[int, int, int, int, bytes]
"""A packet: servo, instruction, first register, number of registers, servos of a sync read."""

PING, READ, SYNC_READ = 0x01, 0x02, 0x82
MEMORY = 256  # bytes of registers
STEPS = 4096  # in a turn
TURN = 6.283185307179586  # rad


TABLES = read_beside(__file__, "servos.json")


def versions(table: dict[str, Any]) -> dict[str, Version]:
    """Return the versions of a table's arms, by name."""
    arms: dict[str, Any] = table["arms"]
    return {name: Version(len(arm["joints"]), 1000.0) for name, arm in arms.items()}


class ServoEmulator(Emulator):
    """Servos that answer when they are asked; what is written to them they ignore."""

    TABLE: ClassVar[dict[str, Any]]
    """Section of ``servos.json``: the driver's address; a packet's head and least length; address
    and size of the registers that are not 0; and by arm the servos' model number, the identifiers
    of those that turn joints, and of the others."""
    stiff = False
    """True if the torque is on."""

    def listen(self, address: str) -> None:
        """Open a pseudo-terminal."""
        arm = self.TABLE["arms"][self.version]
        self.model: int = arm["model"]
        self._joints: list[int] = arm["joints"]
        self._known: list[int] = [*self._joints, *arm["others"]]
        self.errors: dict[int, int] = {}
        """Error code of a servo, by its number."""
        self.turned: dict[int, int] = {}
        """Position of a servo that does not follow its joint, by its number."""
        self._line = SerialPort(self, address, self._receive)
        self.driver_address = self.TABLE["driver"].format(
            port=self._line.name, version=self.version
        )

    @abstractmethod
    def _size(self, received: bytearray) -> int:
        """Return the length of the packet that comes first."""

    @abstractmethod
    def _request(self, packet: bytes) -> Request | None:
        """Return the request of a packet; None if its check fails."""

    @abstractmethod
    def _status(self, servo: int, data: bytes) -> bytes:
        """Return a servo's answer."""

    def _pong(self) -> bytes:
        """Return the data of the answer to a ping."""
        return b""

    def _position(self, steps: int) -> int:
        """Return a position as its register holds it."""
        return steps

    def _receive(self, received: bytearray) -> None:
        """Answer all requests that have come in whole; bytes of no packet are dropped."""
        head = bytes(self.TABLE["head"])
        shortest = self.TABLE["least"]
        while len(received) >= shortest:
            size = self._size(received)
            if not received.startswith(head) or size < shortest:
                del received[:1]
            elif len(received) < size:
                return
            else:
                request = self._request(bytes(received[:size]))
                del received[:size]
                if request:
                    self._reply(*request)

    def _reply(
        self,
        servo: int,
        instruction: int,
        first: int,
        count: int,
        servos: bytes,
    ) -> None:
        self.arm.connect()
        if instruction not in (PING, READ, SYNC_READ):
            return
        asked = [number for number in self._known if servo in (number, 0xFE)]
        if instruction == SYNC_READ:
            asked = [number for number in servos if number in self._known]
        registers: dict[str, tuple[int, int]] = self.TABLE["registers"]
        steps: dict[int, int] = {}
        # The state counts as sent where it is asked for.
        if instruction != PING and first <= registers["position"][0] < first + count:
            position = self.next_state(self.moment).position
            turns = [round(STEPS / 2 + q * STEPS / TURN) for q in position]
            steps = dict(zip(self._joints, turns, strict=True))
        sent: list[bytes] = []
        for number in asked:
            of_joint = steps.get(number, STEPS // 2)
            values = {
                "firmware": self.TABLE["firmware"],
                "model": self.model,
                "servo": number,
                "torque": self.stiff,
                "position": self._position(self.turned.get(number, of_joint)),
            }
            memory = bytearray(MEMORY)
            for name, value in values.items():
                begin, size = registers[name]
                memory[begin : begin + size] = value.to_bytes(size, "little")
            data = bytes(memory[first : first + count])
            answer = self._status(number, self._pong() if instruction == PING else data)
            self.answer(lambda packet, _: sent.append(packet), answer)
        self._line.send(b"".join(sent))  # at once, as a USB adapter hands them over


class DynamixelEmulator(ServoEmulator):
    """X-series servos that speak protocol 2.0: of a ViperX 300 (6 joints) or a Koch."""

    TABLE = TABLES["dynamixel"]
    VERSIONS = versions(TABLE)

    def _size(self, received: bytearray) -> int:
        return int.from_bytes(received[5:7], "little") + 7

    def _request(self, packet: bytes) -> Request | None:
        if crc16(packet[:-2]) != int.from_bytes(packet[-2:], "little"):
            return None
        parameters = packet[8:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
        registers = parameters[:4].ljust(4, b"\0")
        first, count = struct.unpack("<HH", registers)
        return packet[4], packet[7], first, count, parameters[4:]

    def _pong(self) -> bytes:
        firmware = bytes([self.TABLE["firmware"]])
        return self.model.to_bytes(2, "little") + firmware

    def _position(self, steps: int) -> int:
        return steps % (1 << 32)  # two's complement

    def _status(self, servo: int, data: bytes) -> bytes:
        content = bytes([0x55, self.errors.get(servo, 0)]) + data
        content = content.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
        length = len(content) + 2
        head = bytes([*self.TABLE["head"], servo])
        packet = head + length.to_bytes(2, "little") + content
        return packet + crc16(packet).to_bytes(2, "little")


class FeetechEmulator(ServoEmulator):
    """Six STS3215 on a line, of an SO-101."""

    TABLE = TABLES["feetech"]
    VERSIONS = versions(TABLE)

    def _size(self, received: bytearray) -> int:
        return received[3] + 4

    def _request(self, packet: bytes) -> Request | None:
        if sum(packet[2:]) & 0xFF != 0xFF:
            return None
        parameters = packet[5:-1]
        first, count = parameters[:2].ljust(2, b"\0")
        return packet[2], packet[4], first, count, packet[7:-1]

    def _position(self, steps: int) -> int:
        return abs(steps) | (0x8000 if steps < 0 else 0)

    def _status(self, servo: int, data: bytes) -> bytes:
        body = [servo, len(data) + 2, self.errors.get(servo, 0), *data]
        return bytes([0xFF, 0xFF, *body, 0xFF - sum(body) % 256])
