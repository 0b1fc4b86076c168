"""Base of the emulated servos on a line: registers that are read, and an arm behind them."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from .emulator import Emulator
from .ports import SerialPort

Request = tuple[int, int, bytes]
"""A packet: number of the servo, instruction, parameters."""

PING, READ, SYNC_READ = 0x01, 0x02, 0x82
MEMORY = 256  # bytes of registers
STEPS = 4096  # in a turn
TURN = 6.283185307179586  # rad


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
