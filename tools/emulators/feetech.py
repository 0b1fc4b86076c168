"""An SO-101's Feetech servos, on a pseudo-terminal.

Proven against Feetech's own package, feetech-servo-sdk 1.0.0: it pings and reads them.
"""

from collections.abc import Sequence

from .emulator import Version
from .servos import Request, ServoEmulator

STS3215 = 777


class FeetechEmulator(ServoEmulator):
    """Six STS3215 on a line."""

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
