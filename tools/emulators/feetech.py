"""An SO-101's Feetech servos, on a pseudo-terminal.

Proven against Feetech's own package, feetech-servo-sdk 1.0.0: it pings and reads them.
"""

from collections.abc import Sequence

from .servos import Request, ServoEmulator

SO101 = 5  # joints, and a gripper
STS3215 = 777


class FeetechEmulator(ServoEmulator):
    """Six STS3215 on a line."""

    JOINTS = SO101
    VERSIONS = ("so101",)
    RATES = {"so101": 1000.0}  # noqa: RUF012
    POSITION = 56
    IDS = {"so101": (1, 2, 3, 4, 5)}  # noqa: RUF012
    OTHERS = {"so101": (6,)}  # noqa: RUF012

    @property
    def driver_address(self) -> str:
        """The line."""
        return f"feetech:{self.port}"

    def take_request(self, received: bytearray) -> Request | None:
        """Cut by the length, and check the sum."""
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

    def sync_request(self, parameters: bytes) -> tuple[int, int, Sequence[int]]:
        """First register, count, servos."""
        return parameters[0], parameters[1], parameters[2:]

    def read_request(self, parameters: bytes) -> tuple[int, int]:
        """First register, count."""
        return parameters[0], parameters[1]

    def pong(self, servo: int) -> bytes:
        """A bare answer."""
        return b""

    def status(self, servo: int, data: bytes) -> bytes:
        """Without an error."""
        body = [servo, len(data) + 2, 0, *data]
        return bytes([0xFF, 0xFF, *body, 0xFF - sum(body) % 256])

    def fill(self, servo: int, memory: bytearray, steps: int) -> None:
        """Firmware, model, number, torque, position."""
        memory[0:2] = b"\x03\x0a"
        memory[3:5] = STS3215.to_bytes(2, "little")
        memory[5] = servo
        memory[40] = self.stiff
        size = abs(steps) | (0x8000 if steps < 0 else 0)
        memory[56:58] = size.to_bytes(2, "little")
