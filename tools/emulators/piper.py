"""AgileX Piper: its joint angles on a CAN bus.

Proven against piper_sdk 0.6.2, whose parser reads these frames.
"""

import math
import struct
from collections import Counter

from ...drivers import JointState
from .emulator import Emulator, Version
from .ports import CanPort

JOINT_FRAMES = (0x2A5, 0x2A6, 0x2A7)


class PiperEmulator(Emulator):
    """A Piper that sends its joint angles, whoever listens."""

    VERSIONS = {"1": Version(6, 200.0)}  # noqa: RUF012

    def listen(self, address: str) -> None:
        """Join the bus; every frame of anybody else is noted."""
        self._bus = CanPort(self, address, self._overhear)
        self.driver_address = f"piper:{self._bus.address}"
        self._own: Counter[tuple[int, bytes]] = Counter()
        self.begin()

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send the three frames of one state."""
        counts = [round(math.degrees(angle) * 1000) for angle in state.position]
        for index, identifier in enumerate(JOINT_FRAMES):
            pair = struct.pack(">ii", *counts[2 * index : 2 * index + 2])
            self.emit(self._send, pair, moment, identifier)

    def _send(self, data: bytes, identifier: int) -> None:
        self._own[identifier, data] += 1
        self._bus.send(data, identifier)

    def _overhear(self, identifier: int, data: bytes) -> None:
        """Note a frame, unless it is one of ours that the bus brings back."""
        if self._own[identifier, data] > 0:
            self._own[identifier, data] -= 1
        else:
            self.journal.received(f"{identifier:03x}", data)
