"""An arm made of servos on one line, which a hand can lead while its torque is off.

Each state is one *sync read* of all joints; nothing else is ever sent. Before the first one model,
torque and homing offsets are read. Efforts are None: with the torque
off, a servo's load and current are zero.
"""

import math
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from typing import ClassVar

from ... import JointState, ModelNames, PolledDriver, Reason, clock, match_joints
from ...transport import FreshAnswers, SerialLine, parse_options
from .joint_maps import OPTIONS, TICKS, ServoMap, choose_map

BAUD = 1_000_000
RATE = 100.0  # Hz
FIRST_ANSWER_SECONDS = 1.0
ANSWER_SECONDS = (
    0.1  # all servos answer within some 20 ms, even through a slow USB adapter
)
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


@dataclass(frozen=True)
class Register:
    """A number in a servo's memory."""

    address: int
    size: int
    """Bytes, the lowest first."""
    signed: bool = False
    """True for two's complement."""
    sign_bit: int | None = None
    """The bit that is the number's sign, for one that is written as sign and size."""

    def decode(self, data: bytes) -> int:
        """Return the number."""
        number = int.from_bytes(data, "little", signed=self.signed)
        if self.sign_bit is None:
            return number
        size = number & ~(1 << self.sign_bit)
        return -size if number >> self.sign_bit & 1 else size


@dataclass(frozen=True)
class Make:
    """A maker's servos: packets, models, registers and error codes."""

    encode_request: Callable[[int, int, Sequence[int]], bytes]
    """Returns the request for a register on and so many bytes, of these servos."""
    header: bytes
    """The first bytes of an answer; they may stand within data, too."""
    least_bytes: int
    """Of an answer, by which its size is known."""
    size: Callable[[bytearray, int], int]
    """Returns the size of the answer with so many bytes of registers that comes first, 0 if none
    does."""
    decode_answer: Callable[[bytes], Answer]
    """Returns a servo's answer; raises ValueError if the packet is none."""
    arms: dict[str, ServoMap]
    default: str | None
    """The arm where the address names none."""
    models: Container[int]
    """Model numbers that have these registers, and 4096 ticks a turn."""
    model: Register
    torque: Register
    homing: Register
    position: Register
    least: int
    """Range of a plausible position [ticks]."""
    most: int
    troubles: Callable[[int], list[str]]
    """Returns in words what an error code means; raises ValueError if nothing was read."""

    def take_answer(self, received: bytearray, count: int) -> Answer | None:
        """Take the next answer of so many bytes off, and what is none; None if it is not whole."""
        while (start := received.find(self.header)) >= 0:
            del received[:start]
            size = self.size(received, count)
            if len(received) < max(size, self.least_bytes):
                return None
            try:
                answer = self.decode_answer(bytes(received[:size]))
            except ValueError:
                del received[:1]
                continue
            del received[:size]
            if len(answer.data) == count:
                return answer
        del received[: 1 - len(self.header)]
        return None


class ServoArm(PolledDriver):
    """A connection to the servos of an arm."""

    make: ClassVar[Make]
    resolution = 2 * math.pi / TICKS

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        port, _, query = address.partition("?")
        options = parse_options(query, ("baud", "rate", *OPTIONS))
        if not port:
            raise Reason.BAD_ADDRESS(
                "a serial port is missing, as in /dev/ttyACM0 or /dev/ttyUSB0"
            )
        self._map = choose_map(options, self.make.arms, self.make.default)
        super().__init__(f"the servo bus on {port}")
        self._joint_names = match_joints(
            joint_names or self._map.joints, len(self._map.ids), "the arm"
        )
        self._interval = 1 / options.positive("rate", RATE)
        self._line = SerialLine(port, options.integer("baud", BAUD))
        self._fresh = FreshAnswers(self._line.discard)
        with self._closed_on_error():
            self._inspect()

    def _receive(self, deadline: float) -> JointState:
        start = self._await_turn(deadline, self._interval)
        answers = self._ask(self.make.position)
        stamp = (start + clock.now()) / 2
        angles: list[float] = []
        joints = zip(answers, self._map.signs, self._map.zeros, strict=True)
        for answer, sign, zero in joints:
            ticks = self.make.position.decode(answer.data)
            if not self.make.least <= ticks <= self.make.most:
                raise ValueError(
                    f"position {ticks} of servo {answer.servo}, beyond its turn: turn the joint to "
                    "the middle of its range, and switch the arm off and on"
                )
            angles.append(sign * (ticks - zero) * 2 * math.pi / TICKS)
        return JointState(stamp, tuple(angles))

    def _disconnect(self) -> None:
        self._line.close()

    def _ask(self, register: Register) -> list[Answer]:
        """Return all joints' answers, and name their troubles in the status."""
        answers = self._fresh.ask(lambda: self._read(register.address, register.size))
        troubles = list[str]()
        for joint, answer in zip(self._map.joints, answers, strict=True):
            troubles += [
                f"{joint}: {trouble}" for trouble in self.make.troubles(answer.error)
            ]
        self.status = ", ".join(troubles)
        return answers

    def _read(self, register: int, count: int) -> list[Answer]:
        """Return so many bytes of the servos' registers, from one on."""
        servos = self._map.ids
        self._line.write(self.make.encode_request(register, count, servos))
        answers: dict[int, Answer] = {}
        received, until = bytearray(), clock.now() + ANSWER_SECONDS
        while not answers.keys() >= set(servos):
            answer = self.make.take_answer(received, count)
            if answer is not None:
                answers[answer.servo] = answer
                continue
            came = self._line.read(MOST_BYTES, until - clock.now())
            if not came:
                silent = ", ".join(
                    str(servo) for servo in servos if servo not in answers
                )
                raise ValueError(f"no whole answer of servo {silent}")
            received += came
        return [answers[servo] for servo in servos]

    def _inspect(self) -> None:
        """See that these are the right servos, and that their torque is off."""
        numbers = self.make.models
        models = self._find(
            self.make.model, lambda replies: all(model in numbers for model in replies)
        )
        for servo, model in zip(self._map.ids, models, strict=True):
            if model not in numbers:
                raise Reason.WRONG_ROBOT(
                    f"servo {servo} on {self._where} is of model {model}, which is not known here"
                )
        torques = self._find(self.make.torque, lambda replies: not any(replies))
        if stiff := self._named(torques, [0] * len(torques)):
            raise Reason.WRONG_MODE(
                f"the torque is on at {stiff}: end the program that uses the arm, or switch its "
                "power off and on, and hold the arm, which falls without torque"
            )
        homing = self._map.homing
        offsets = self._find(self.make.homing, lambda offsets: tuple(offsets) == homing)
        self.identity = f"homing offsets {', '.join(map(str, offsets))}"
        if homing is None:
            return
        if changes := self._named(offsets, homing):
            raise Reason.WRONG_ROBOT(
                f"the servos at {changes} have another homing offset than the calibration file: it "
                "is another arm's, or not the latest; connect lerobot once, or give the right file"
            )

    def _named(self, numbers: Sequence[int], reference: Sequence[int]) -> str:
        """Return the names of the joints whose numbers are not what is wanted."""
        rows = zip(self._map.joints, numbers, reference, strict=True)
        return ", ".join(
            joint for joint, number, expected in rows if number != expected
        )

    def _find(self, register: Register, test: Callable[[list[int]], bool]) -> list[int]:
        """Return a register of all joints; what is not right is believed when it comes twice."""
        end = clock.now() + FIRST_ANSWER_SECONDS
        last: list[int] = []
        while True:
            try:
                before, last = (
                    last,
                    [register.decode(a.data) for a in self._ask(register)],
                )
                if last == before or test(last):
                    return last
            except ValueError as error:
                if clock.now() > end:
                    raise Reason.UNREACHABLE(
                        f"{error} on {self._where}: is the arm's power on, and are arm and baud "
                        "right?"
                    ) from None
