"""Servos on a pseudo-terminal: registers that are read, and an arm behind them.

Proven against dynamixel_sdk 4.1.0 and feetech-servo-sdk 1.0.0, which ping and read them.
"""

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from .emulator import Emulator, Version
from .ports import SerialPort

Request = tuple[int, int, bytes]
"""A packet: number of the servo, instruction, parameters."""

PING, READ, SYNC_READ = 0x01, 0x02, 0x82
MEMORY = 256  # bytes of registers
STEPS = 4096  # in a turn
TURN = 6.283185307179586  # rad
MODELS = {"vx300s": 1120, "koch": 1060}  # XM540-W270, XL430-W250
FIRMWARE = 45
STS3215 = 777


class ServoEmulator(Emulator):
    """Servos that answer when they are asked; what is written to them they ignore."""

    POLLED = True
    NAMED: ClassVar[str]
    """Driver and address of a port and a version."""
    POSITION: ClassVar[int]
    """The register in which the position begins."""
    IDS: ClassVar[dict[str, tuple[int, ...]]]
    """Numbers of the servos that turn the joints of each version's arm."""
    OTHERS: ClassVar[dict[str, tuple[int, ...]]]
    """Numbers of those of its gripper, and of those that help others."""
    stiff = False
    """True if the torque is on."""

    def listen(self, address: str) -> None:
        """Open a pseudo-terminal."""
        self.errors: dict[int, int] = {}
        """Error code of a servo, by its number."""
        self.turned: dict[int, int] = {}
        """Position of a servo that does not follow its joint, by its number."""
        self._line = SerialPort(self, address, self._hear)
        self.driver_address = self.NAMED.format(port=self._line.name, version=self.version)

    @abstractmethod
    def _take_request(self, received: bytearray) -> Request | None:
        """Take the next whole packet off; bytes that are none are dropped."""

    @abstractmethod
    def _registers(self, parameters: bytes) -> tuple[int, int, Sequence[int]]:
        """Return the first register that is asked for, how many, and of which servos if told."""

    @abstractmethod
    def _pong(self, servo: int) -> bytes:
        """Return the data of the answer to a ping."""

    @abstractmethod
    def _status(self, servo: int, data: bytes) -> bytes:
        """Return a servo's answer."""

    @abstractmethod
    def _fill(self, servo: int, memory: bytearray, steps: int) -> None:
        """Write a servo's registers, its position among them."""

    def _hear(self, received: bytearray) -> None:
        before = bytes(received)
        while (request := self._take_request(received)) is not None:
            self.journal.received("line", before[: len(before) - len(received)])
            before = bytes(received)
            self._reply(*request)

    def _reply(self, servo: int, instruction: int, parameters: bytes) -> None:
        known = (*self.IDS[self.version], *self.OTHERS[self.version])
        self.begin()
        asked: Sequence[int] = [one for one in known if servo in (one, 0xFE)]
        if instruction == PING:
            answers = [(one, self._pong(one)) for one in asked]
        elif instruction in (READ, SYNC_READ):
            first, count, servos = self._registers(parameters)
            asked = asked if instruction == READ else servos
            steps = self._steps(first, count, self.moment)
            answers = [(one, self._memory(one, steps)[first : first + count]) for one in asked]
        else:
            return
        sent: list[bytes] = []
        for one, data in answers:
            if one in known:
                self.answer(lambda packet, _: sent.append(packet), self._status(one, data))
        self._line.send(b"".join(sent))  # at once, as a USB adapter hands them over

    def _steps(self, first: int, count: int, moment: float) -> dict[int, int]:
        """Return each servo's position; the state counts as sent where it is asked for."""
        position = (0.0,) * len(self.IDS[self.version])
        if first <= self.POSITION < first + count:
            position = self.next_state(moment).position
        pairs = zip(self.IDS[self.version], position, strict=True)
        return {servo: round(STEPS / 2 + q * STEPS / TURN) for servo, q in pairs}

    def _memory(self, servo: int, steps: dict[int, int]) -> bytes:
        memory = bytearray(MEMORY)
        self._fill(servo, memory, self.turned.get(servo, steps.get(servo, STEPS // 2)))
        return bytes(memory)


class DynamixelEmulator(ServoEmulator):
    """X-series servos that speak protocol 2.0: of a ViperX 300 (6 joints) or a Koch."""

    VERSIONS = {"vx300s": Version(6, 1000.0), "koch": Version(5, 1000.0)}  # noqa: RUF012
    NAMED = "dynamixel:{port}?arm={version}"
    POSITION = 132
    IDS = {"vx300s": (1, 2, 4, 6, 7, 8), "koch": (1, 2, 3, 4, 5)}  # noqa: RUF012
    OTHERS = {"vx300s": (3, 5, 9), "koch": (6,)}  # noqa: RUF012

    def _take_request(self, received: bytearray) -> Request | None:
        while len(received) >= 10:
            if not received.startswith(b"\xff\xff\xfd\x00"):
                del received[:1]
                continue
            size = int.from_bytes(received[5:7], "little") + 7
            if len(received) < size:
                return None
            packet = bytes(received[:size])
            del received[:size]
            if crc16(packet[:-2]) == int.from_bytes(packet[-2:], "little"):
                return (
                    packet[4],
                    packet[7],
                    packet[8:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd"),
                )
        return None

    def _registers(self, parameters: bytes) -> tuple[int, int, Sequence[int]]:
        first, count = parameters[:2], parameters[2:4]
        return int.from_bytes(first, "little"), int.from_bytes(count, "little"), parameters[4:]

    def _pong(self, servo: int) -> bytes:
        return MODELS[self.version].to_bytes(2, "little") + bytes([FIRMWARE])

    def _status(self, servo: int, data: bytes) -> bytes:
        content = (bytes([0x55, self.errors.get(servo, 0)]) + data).replace(
            b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"
        )
        packet = b"\xff\xff\xfd\x00" + bytes([servo])
        packet += (len(content) + 2).to_bytes(2, "little") + content
        return packet + crc16(packet).to_bytes(2, "little")

    def _fill(self, servo: int, memory: bytearray, steps: int) -> None:
        memory[0:2] = MODELS[self.version].to_bytes(2, "little")
        memory[6], memory[7] = FIRMWARE, servo
        memory[64] = self.stiff
        memory[132:136] = steps.to_bytes(4, "little", signed=True)


def crc16(data: bytes) -> int:
    """Return the CRC of a packet, bit by bit."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = crc << 1 ^ (0x18005 if crc & 0x8000 else 0)
    return crc


class FeetechEmulator(ServoEmulator):
    """Six STS3215 on a line, of an SO-101."""

    VERSIONS = {"so101": Version(5, 1000.0)}  # noqa: RUF012
    NAMED = "feetech:{port}"
    model = STS3215
    POSITION = 56
    IDS = {"so101": (1, 2, 3, 4, 5)}  # noqa: RUF012
    OTHERS = {"so101": (6,)}  # noqa: RUF012

    def _take_request(self, received: bytearray) -> Request | None:
        while len(received) >= 6:
            size = received[3] + 4
            if not received.startswith(b"\xff\xff") or received[3] < 2:
                del received[:1]
                continue
            if len(received) < size:
                return None
            packet = bytes(received[:size])
            del received[:size]
            if sum(packet[2:]) & 0xFF == 0xFF:
                return packet[2], packet[4], packet[5:-1]
        return None

    def _registers(self, parameters: bytes) -> tuple[int, int, Sequence[int]]:
        return parameters[0], parameters[1], parameters[2:]

    def _pong(self, servo: int) -> bytes:
        return b""

    def _status(self, servo: int, data: bytes) -> bytes:
        body = [servo, len(data) + 2, self.errors.get(servo, 0), *data]
        return bytes([0xFF, 0xFF, *body, 0xFF - sum(body) % 256])

    def _fill(self, servo: int, memory: bytearray, steps: int) -> None:
        memory[0:2] = b"\x03\x0a"
        memory[3:5] = self.model.to_bytes(2, "little")
        memory[5] = servo
        memory[40] = self.stiff
        size = abs(steps) | (0x8000 if steps < 0 else 0)
        memory[56:58] = size.to_bytes(2, "little")
