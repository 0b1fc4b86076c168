"""Base of the emulated controllers: an arm, a clock, a journal, faults, and one loop."""

import json
import math
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from ...drivers import JointState, clock
from ...drivers.arms import SimulatedArm
from ...errors import MukcaError
from .arm import COMMON_KINDS, FaultInjector

IDLE_SECONDS = (
    0.5  # a signal just before a wait without end would be seen only after it
)


class Journal:
    """A file of JSON lines: every message that came in, and every state that went out."""

    def __init__(self, path: Path | None) -> None:
        try:
            # It is written line by line.
            self._stream = path.open("w", 1, encoding="utf-8") if path else None
        except OSError as error:
            raise MukcaError(f"{path}: cannot be written: {error.strerror}") from None

    def received(self, channel: str, message: bytes) -> None:
        """Note a message that came in."""
        self._write(channel=channel, received=message.hex())

    def sent(self, number: int, state: JointState) -> None:
        """Note a state that went out."""
        position, effort = state.position, state.effort
        self._write(sent=number, at=clock.now(), position=position, effort=effort)

    def close(self) -> None:
        """Write what is left."""
        if self._stream:
            self._stream.close()

    def _write(self, **line: Any) -> None:
        if self._stream:
            self._stream.write(json.dumps(line) + "\n")


class Version(NamedTuple):
    """Version of a protocol or a controller: its arm's joints, and states per second."""

    joints: int
    rate: float


class Emulator(ABC):
    """One controller at an address, empty for the real ports on 127.0.0.1.

    Its arm starts with the first connection; the journal notes messages and states.
    """

    VERSIONS: ClassVar[dict[str, Version]]
    """Versions of the protocol or the controller; the first is the default."""
    FAULTS: ClassVar[tuple[str, ...]] = COMMON_KINDS
    """Kinds of faults that it can show."""

    def __init__(
        self,
        address: str,
        version: str,
        arm: SimulatedArm,
        faults: FaultInjector,
        journal: Journal,
    ) -> None:
        self.version = version
        self.arm, self.faults, self.journal = arm, faults, journal
        self.driver_address = ""
        """Driver and address, as ``--driver`` takes them to read this emulator."""
        self.number = 0
        """Number of the last state."""
        self.streaming = False
        """True while states go out unasked; always False where it only answers."""
        self._released = 0.0
        """End of the arm's rest at its first pose [s]."""
        self.watched: dict[int, Callable[[], None]] = {}
        """Callbacks by the file descriptor that can be read."""
        self.on_away: list[Callable[[], None]] = []
        """Called while a fault keeps it from serving anybody."""
        self.opened = ExitStack()
        """Sockets, lines and buses, to be closed at the end."""
        self._streaming_since = math.nan
        self._sent = 0
        self._frozen: JointState | None = None
        self.listen(address)

    @abstractmethod
    def listen(self, address: str) -> None:
        """Open the sockets, watch them, and set :attr:`driver_address`."""

    def send_state(self, state: JointState, moment: float) -> None:
        """Send one state to whoever is connected; called while :attr:`streaming`."""
        raise NotImplementedError

    @property
    def moment(self) -> float:
        """The arm's time [s]: it stands at 0 until the first connection."""
        return self.arm.now()

    def is_away(self, moment: float) -> bool:
        """Return whether a fault keeps it from serving anybody at a moment [s]."""
        return any(self.faults.is_active(kind, moment) for kind in ("hangup", "busy"))

    def close(self) -> None:
        """Close sockets and lines, leave buses."""
        self.opened.close()

    def wait_for_line(self, file: int) -> None:
        """Keep the arm at its first pose until a line, or the end, comes from a file."""
        self._released = math.inf

        def release() -> None:
            os.read(file, 1)
            self._released = self.moment
            self.watched.pop(file, None)

        self.watched[file] = release

    def serve(self) -> None:
        """Run until interrupted."""
        while True:
            pause = max(0.0, min(IDLE_SECONDS, self.due() - clock.now()))
            self.dispatch(clock.wait(list(self.watched), pause))
            self.send_due()

    def dispatch(self, readable: Sequence[int]) -> None:
        """Call back for the file descriptors that can be read."""
        # Clients that leave come before clients that join.
        for file in reversed(readable):
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
        late = clock.now() - self.due()
        if late >= 0:
            moment = max(0.0, self.moment - late)
            state = self.next_state(moment)
            if self.is_away(moment):
                for leave in self.on_away:
                    leave()
            else:
                self.send_state(state, moment)
            self._sent += 1

    def next_state(self, moment: float) -> JointState:
        """Return the next state, counted and noted."""
        state = self.arm.state(max(0.0, moment - self._released))
        is_frozen = self.faults.is_active("freeze", moment)
        self._frozen = (self._frozen or state) if is_frozen else None
        self.number += 1
        sent = self._frozen or state
        self.journal.sent(self.number, sent)
        return sent

    def emit(
        self,
        send: Callable[[bytes, Any], object],
        message: bytes,
        moment: float,
        target: Any = 0,
    ) -> None:
        """Send a message to a target by way of a port, faults applied."""
        for receiver, packet in self.faults.packets((target, message), moment):
            send(packet, receiver)

    def answer(
        self,
        send: Callable[[bytes, Any], object],
        message: bytes,
        target: Any = 0,
    ) -> None:
        """Answer a request, unless it serves nobody now."""
        if not self.is_away(self.moment):
            self.emit(send, message, self.moment, target)
