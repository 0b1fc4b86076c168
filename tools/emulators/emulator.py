"""What all emulated controllers have in common: an arm, a clock, a journal, and one loop."""

import json
import math
import os
import socket
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar

from ...drivers import JointState, clock
from ...drivers.arms import SimulatedArm
from ...errors import MukcaError
from .sabotage import COMMON_KINDS, FaultInjector, Packet

IDLE_SECONDS = 0.5  # a signal just before a wait without end would be seen only after it


class Journal:
    """A file of JSON lines: every message that came in, and every state that went out."""

    def __init__(self, path: Path | None) -> None:
        try:
            self._stream = path.open("w", 1, encoding="utf-8") if path else None  # line by line
        except OSError as error:
            raise MukcaError(f"{path}: cannot be written: {error.strerror}") from None

    def received(self, channel: str, message: bytes) -> None:
        """Note a message that came in."""
        self._write({"channel": channel, "received": message.hex()})

    def sent(self, number: int, state: JointState) -> None:
        """Note a state that went out."""
        if self._stream:
            content = {"position": state.position, "effort": state.effort}
            self._write({"sent": number, "at": clock.now(), **content})

    def close(self) -> None:
        """Write what is left."""
        if self._stream:
            self._stream.close()

    def _write(self, line: dict[str, Any]) -> None:
        if self._stream:
            self._stream.write(json.dumps(line) + "\n")


class Emulator(ABC):
    """One controller.

    Args:
        address: Where it listens or sends to; empty for the real ports on 127.0.0.1.
        version: One of :attr:`VERSIONS`.
        arm: What moves; it starts with the first connection.
        sabotage: What goes wrong.
        journal: Where messages and states are noted.
    """

    JOINTS: ClassVar[int]
    VERSIONS: ClassVar[tuple[str, ...]]
    """What it can be; the first is the default."""
    RATES: ClassVar[dict[str, float]]
    """States per second of each version."""
    FAULTS: ClassVar[tuple[str, ...]] = COMMON_KINDS
    """What can go wrong with it."""

    def __init__(
        self,
        address: str,
        version: str,
        arm: SimulatedArm,
        sabotage: FaultInjector,
        journal: Journal,
    ) -> None:
        self.version = version
        self.arm, self.sabotage, self.journal = arm, sabotage, journal
        self.number = 0
        """Number of the last state."""
        self._released = 0.0
        """Until when the arm rests at its first pose [s]."""
        self.watched: dict[int, Callable[[], None]] = {}
        """What is done when a file descriptor can be read."""
        self._begun = math.nan
        self._streaming_since = math.nan
        self._sent = 0
        self._frozen: JointState | None = None
        self.listen(address)

    @classmethod
    def joints(cls, version: str) -> int:
        """Return how many joints the arm of a version has."""
        return cls.JOINTS

    @abstractmethod
    def listen(self, address: str) -> None:
        """Open the sockets, and watch them."""

    @abstractmethod
    def send_state(self, number: int, state: JointState, moment: float) -> None:
        """Send one state to whoever is connected."""

    @property
    @abstractmethod
    def driver_address(self) -> str:
        """What ``--driver`` takes to read this emulator."""

    @property
    def streaming(self) -> bool:
        """Whether there is anybody to send to."""
        return True

    @property
    def moment(self) -> float:
        """The arm's time [s]: it stands at 0 until the first connection."""
        return 0.0 if math.isnan(self._begun) else clock.now() - self._begun

    def begin(self) -> None:
        """Let the arm move, if it does not yet."""
        if math.isnan(self._begun):
            self._begun = clock.now()

    def close(self) -> None:  # noqa: B027 - most have nothing to do
        """Leave what does not close by itself at the end of the program."""

    def wait_for_line(self, file: int) -> None:
        """Keep the arm at its first pose until a line, or the end, comes from a file."""
        self._released = math.inf

        def release() -> None:
            os.read(file, 1)
            self._released = self.moment
            self.unwatch(file)

        self.watch(file, release)

    def watch(self, file: int, callback: Callable[[], None]) -> None:
        """Call back whenever a file descriptor can be read."""
        self.watched[file] = callback

    def unwatch(self, file: int) -> None:
        """Watch a file descriptor no longer."""
        self.watched.pop(file, None)

    def serve(self) -> None:
        """Run until interrupted."""
        while True:
            pause = max(0.0, min(IDLE_SECONDS, self.due() - clock.now()))
            self.heed(clock.wait(list(self.watched), pause))
            self.send_due()

    def heed(self, readable: Sequence[int]) -> None:
        """Call back for the file descriptors that can be read."""
        for file in reversed(readable):  # clients that leave come before clients that join
            if file in self.watched:
                self.watched[file]()

    def due(self) -> float:
        """Return when the next state leaves [s]; never while there is nobody to send to."""
        if not self.streaming:
            self._streaming_since = math.nan
            return math.inf
        if math.isnan(self._streaming_since):
            self._streaming_since, self._sent = clock.now(), 0
        return self._streaming_since + self._sent / self.arm.rate

    def send_due(self) -> None:
        """Send the next state, if it is time to."""
        due = self.due()
        if clock.now() >= due:
            self._send_next(0.0 if math.isnan(self._begun) else max(0.0, due - self._begun))
            self._sent += 1

    def _send_next(self, moment: float) -> None:
        state = self.next_state(moment)
        self.send_state(self.number, state, moment)

    def next_state(self, moment: float) -> JointState:
        """Return what is sent next, counted and noted."""
        state = self.arm.state(max(0.0, moment - self._released))
        if self.sabotage.strikes("freeze", moment):
            state = self._frozen = self._frozen or state
        else:
            self._frozen = None
        self.number += 1
        self.journal.sent(self.number, state)
        return state

    def packets(self, payload: bytes, moment: float, identifier: int = 0) -> Sequence[Packet]:
        """Return what is really sent for a message."""
        return self.sabotage.packets((identifier, payload), moment)


def stranger_socket() -> socket.socket:
    """Return a UDP socket on a loopback address that is no robot's."""
    stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    stranger.bind(("127.66.66.66", 0))
    return stranger
