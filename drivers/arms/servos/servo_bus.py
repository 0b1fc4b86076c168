"""A line of servos: one *sync read* names them all, and each answers in turn.

*Sync read*, "tell me so many bytes of your registers, from this one on", is the only request.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from ... import clock
from ...transport import FreshAnswers, SerialLine

ANSWER_SECONDS = 0.1  # all servos answer within some 20 ms, even through a slow USB adapter
MOST_BYTES = 4096


@dataclass(frozen=True, slots=True)
class Answer:
    """A servo's answer."""

    servo: int
    """Its number on the bus."""
    error: int
    """Error by the make's own code; 0 if none."""
    data: bytes
    """Its registers."""


class Packets(Protocol):
    """Requests and answers as a make writes them."""

    def encode_request(self, register: int, count: int, servos: Sequence[int]) -> bytes:
        """Return the request for the servos' registers, so many bytes from one on."""
        ...

    def take_answer(self, received: bytearray, count: int) -> Answer | None:
        """Take the next answer of so many bytes off; other bytes are dropped; None if not whole."""
        ...


class ServoBus:
    """Servos on a serial line."""

    def __init__(self, line: SerialLine, packets: Packets) -> None:
        self._line, self._packets = line, packets
        self._fresh = FreshAnswers(line)

    def ask(self, register: int, count: int, servos: Sequence[int]) -> list[Answer]:
        """Return so many bytes of the servos' registers, from one on, in the order asked."""
        return self._fresh.ask(lambda: self._ask(register, count, servos))

    def _ask(self, register: int, count: int, servos: Sequence[int]) -> list[Answer]:
        self._line.write(self._packets.encode_request(register, count, servos))
        answers: dict[int, Answer] = {}
        received, until = bytearray(), clock.now() + ANSWER_SECONDS
        while not answers.keys() >= set(servos):
            answer = self._packets.take_answer(received, count)
            if answer is not None:
                answers[answer.servo] = answer
                continue
            came = self._line.read(MOST_BYTES, until - clock.now())
            if not came:
                missing = ", ".join(str(servo) for servo in servos if servo not in answers)
                raise ValueError(f"no whole answer of servo {missing}")
            received += came
        return [answers[servo] for servo in servos]

    def close(self) -> None:
        """Free the line."""
        self._line.close()
