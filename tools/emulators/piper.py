"""AgileX Piper: its joint angles on a CAN bus.

Proven against piper_sdk 0.6.2, whose parser reads these frames.
"""

import math
import struct
from collections import Counter

import can

from ...drivers import JointState
from ...drivers.transport import open_bus, parse_can_address
from .emulator import Emulator, Version

DEFAULT_BUS = "udp_multicast/239.74.163.2?port=43113&hop_limit=0"
JOINT_FRAMES = (0x2A5, 0x2A6, 0x2A7)


class PiperEmulator(Emulator):
    """A Piper that sends its joint angles, whoever listens."""

    VERSIONS = {"1": Version(6, 200.0)}  # noqa: RUF012

    def listen(self, address: str) -> None:
        """Join the bus; every frame of anybody else is noted."""
        address = address or DEFAULT_BUS
        self.driver_address = f"piper:{address}"
        self._bus = open_bus(parse_can_address(address))
        self.opened.callback(self._bus.shutdown)
        self._own: Counter[tuple[int, bytes]] = Counter()
        self.watch(self._bus.fileno(), self._overhear)
        self.begin()

    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send the three frames of one state."""
        if self.is_away(moment):
            return
        counts = [round(math.degrees(angle) * 1000) for angle in state.position]
        for index, identifier in enumerate(JOINT_FRAMES):
            pair = struct.pack(">ii", *counts[2 * index : 2 * index + 2])
            for sent_as, data in self.packets(pair, moment, identifier):
                self._own[sent_as, data] += 1
                self._bus.send(can.Message(arbitration_id=sent_as, data=data, is_extended_id=False))

    def _overhear(self) -> None:
        """Note a frame, unless it is one of ours that the bus brings back."""
        frame = self._bus.recv(0)
        if frame is None:
            return
        key = frame.arbitration_id, bytes(frame.data)
        if self._own[key] > 0:
            self._own[key] -= 1
        else:
            self.journal.received(f"{frame.arbitration_id:03x}", bytes(frame.data))
