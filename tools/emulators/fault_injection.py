"""Fault injection into an emulated controller: faults hit messages by share, start and duration."""

import random
from collections.abc import Sequence
from typing import Any

from ...drivers.arms import Fault

KINDS = {
    "drop": "messages are lost",
    "reorder": "a message comes after the one that follows it",
    "duplicate": "a message comes twice",
    "truncate": "a message ends early",
    "garble": "a message's bytes are random",
    "freeze": "messages come, with the joint angles of the moment at which it began",
    "silent": "nothing comes, no answer either; the connection stands",
    "stall": "nothing comes; then all of it comes at once",
    "hangup": "the connection is ended, and none is taken",
    "busy": "connections are taken and ended without an answer",
    "stranger": "a message comes once more, changed, from another host (franka, kuka)",
    "version": "it announces a version that nobody reads (franka, kuka, ur)",
    "commanding": "the session goes on to commanding (kuka)",
}
"""Kinds of faults; not every controller has a way to show the last three."""
COMMON_KINDS = tuple(kind for kind in KINDS if kind not in ("stranger", "version", "commanding"))

Packet = tuple[Any, bytes]
"""A message: its CAN identifier or UDP address, if it has one, and its bytes."""


class FaultInjector:
    """Applies faults to the messages of a controller."""

    def __init__(self, faults: Sequence[Fault], seed: int = 0) -> None:
        self._faults = faults
        self._random = random.Random(seed)  # noqa: S311 - noise, no secret
        self._held_back: list[Packet] = []
        self._stalled: list[Packet] = []

    def is_active(self, kind: str, moment: float) -> bool:
        """Return whether a kind of fault affects a message at a moment [s]."""
        return any(
            fault.kind == kind and fault.affects(moment, self._random) for fault in self._faults
        )

    def packets(self, packet: Packet, moment: float) -> list[Packet]:
        """Return the packets that are sent in a packet's stead, in order."""
        if not self._faults:
            return [packet]
        if self.is_active("silent", moment) or self.is_active("drop", moment):
            return []
        if self.is_active("truncate", moment):
            packet = packet[0], packet[1][: self._random.randrange(len(packet[1]))]
        if self.is_active("garble", moment):
            packet = packet[0], self._random.randbytes(len(packet[1]))
        if self.is_active("reorder", moment) and not self._held_back:
            self._held_back.append(packet)
            return []
        sent = [packet] * (2 if self.is_active("duplicate", moment) else 1)
        sent = [*self._stalled, *sent, *self._held_back]
        self._stalled, self._held_back = [], []
        if self.is_active("stall", moment):
            self._stalled, sent = sent, []
        return sent
