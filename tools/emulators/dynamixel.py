"""The Dynamixel servos of a ViperX 300 (6 joints) or a Koch, on a pseudo-terminal.

Proven against ROBOTIS' own package, dynamixel_sdk 4.1.0: it pings and reads them.
"""

from collections.abc import Sequence

from .emulator import Version
from .servos import Request, ServoEmulator

MODELS = {"vx300s": 1120, "koch": 1060}  # XM540-W270, XL430-W250
FIRMWARE = 45


class DynamixelEmulator(ServoEmulator):
    """X-series servos that speak protocol 2.0."""

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
