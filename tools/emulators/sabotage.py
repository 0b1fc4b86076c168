"""Misbehaviour of an emulated controller: what goes wrong, how often, and when.

A fault is written ``KIND[:SHARE][@START[+DURATION]]``: SHARE of the messages (1), from START (0 s
after the first connection; after the start of a controller that just sends) for DURATION (for
good), as in ``drop:0.05`` or ``silent@3+0.5``. :data:`KINDS` says what there is.
"""

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

from ...errors import MukcaError

KINDS = {
    "drop": "messages are lost",
    "reorder": "a message comes after the one that follows it",
    "duplicate": "a message comes twice",
    "truncate": "a message ends early",
    "garble": "a message's bytes are random",
    "freeze": "messages come, with the joint angles of the moment at which it began",
    "silent": "nothing comes; the connection stands",
    "hangup": "the connection is ended, and none is taken",
    "busy": "connections are taken and ended without an answer",
    "stranger": "a message comes once more, changed, from another host (franka, kuka)",
    "version": "it announces a version that nobody reads (franka, kuka, ur)",
    "commanding": "the session goes on to commanding (kuka)",
}
"""What can go wrong; not every controller has a way to show the last three."""
COMMON_KINDS = tuple(kind for kind in KINDS if kind not in ("stranger", "version", "commanding"))

Packet = tuple[int, bytes]
"""A message: its CAN identifier (0 elsewhere), and its bytes."""


@dataclass(frozen=True, slots=True)
class Fault:
    """One misbehaviour."""

    kind: str
    share: float = 1.0
    start: float = 0.0
    """[s]"""
    duration: float = math.inf
    """[s]"""

    @classmethod
    def parse(cls, text: str) -> "Fault":
        """Read ``KIND[:SHARE][@START[+DURATION]]``.

        Raises:
            MukcaError: The text is no such thing.
        """
        what, _, when = text.partition("@")
        kind, _, share = what.partition(":")
        start, _, duration = when.partition("+")
        try:
            fault = cls(kind, float(share or 1), float(start or 0), float(duration or math.inf))
        except ValueError:
            raise MukcaError(
                f"fault {text!r}: expected KIND[:SHARE][@START[+DURATION]], as in drop:0.05@2+3"
            ) from None
        if kind not in KINDS or not 0 < fault.share <= 1:
            raise MukcaError(
                f"fault {text!r}: the share is from 0 to 1, and the kind one of {', '.join(KINDS)}"
            )
        return fault


class FaultInjector:
    """Applies faults to what a controller is about to send."""

    def __init__(self, faults: Sequence[Fault], seed: int = 0) -> None:
        self._faults = faults
        self._random = random.Random(seed)  # noqa: S311 - noise, no secret
        self._held_back: list[Packet] = []

    def strikes(self, kind: str, moment: float) -> bool:
        """Tell whether a fault strikes a message at a moment [s]."""
        return any(
            fault.kind == kind
            and fault.start <= moment < fault.start + fault.duration
            and (fault.share == 1 or self._random.random() < fault.share)
            for fault in self._faults
        )

    def packets(self, packet: Packet, moment: float) -> list[Packet]:
        """Return what is sent in a packet's stead, in order."""
        if not self._faults:
            return [packet]
        if self.strikes("silent", moment) or self.strikes("drop", moment):
            return []
        if self.strikes("truncate", moment):
            packet = packet[0], packet[1][: self._random.randrange(len(packet[1]))]
        if self.strikes("garble", moment):
            packet = packet[0], self._random.randbytes(len(packet[1]))
        if self.strikes("reorder", moment) and not self._held_back:
            self._held_back.append(packet)
            return []
        sent = [packet] * (2 if self.strikes("duplicate", moment) else 1)
        sent += self._held_back
        self._held_back.clear()
        return sent
