"""A line of servos: one *sync read* names them all, and each answers in turn.

*Sync read*, "tell me so many bytes of your registers, from this one on", is the only request.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from ... import clock
from ...transport import SerialLine

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
        """Take the next answer with so many bytes of registers off; None if it is not whole yet.

        Bytes that are no such answer are dropped.
        """
        ...


class ServoBus:
    """Servos on a serial line.

    Args:
        line: The line.
        packets: The make's packets.
    """

    def __init__(self, line: SerialLine, packets: Packets) -> None:
        self._line, self._packets = line, packets

    def ask(self, register: int, count: int, servos: Sequence[int]) -> list[Answer]:
        """Return the servos' registers, in the order asked.

        Args:
            register: The first one's address.
            count: Number of bytes.
            servos: Numbers of the servos.

        Raises:
            ValueError: A servo gave no whole answer; the message names it.
            DriverError: UNREACHABLE when the line is lost.
        """
        self._line.flush()
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
