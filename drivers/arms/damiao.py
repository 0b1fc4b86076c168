"""Damiao motors on a CAN bus, as in OpenArm: they are polled while they are switched off.

Only *refresh* and queries for PMAX and the serial number are sent, which enable no motor. A motor
that is enabled, or of another PMAX than 12.5 rad, is refused.

Address: ``[INTERFACE/]CHANNEL[?rate=HZ&ids=1,2,..&signs=1,-1,..]``, see :mod:`..transport.can_bus`.
"""

import struct
from collections.abc import Callable
from functools import partial
from typing import TypeVar

from .. import JointState, ModelNames, PolledDriver, Reason, clock, match_joints
from ..transport import CanBus, FreshAnswers, parse_can_address

JOINTS = 7
EVERYBODY = 0x7FF
ANSWERS = 0x10  # above a motor's number
REFRESH, QUERY = 0xCC, 0x33
PMAX_REGISTER, SERIAL = 0x15, 0x0F
FORMS = {PMAX_REGISTER: "<f", SERIAL: "<I"}
# Answers to one who reads, writes or saves a motor's registers.
REGISTERS = (
    QUERY,
    0x55,
    0xAA,
)
PMAX = 12.5  # rad
COUNTS = 65535
ENABLED = 1
_TROUBLES = (
    "over-voltage, under-voltage, over-current, too hot, rotor too hot, lost communication, "
    "overload"
)
TROUBLES = dict(enumerate(_TROUBLES.split(", "), 8))
RATE = 100.0  # Hz
ANSWER_SECONDS = 0.1
FIRST_ANSWER_SECONDS = 1.0

Decoded = TypeVar("Decoded")


def decode_feedback(data: bytes, motor: int) -> tuple[float, int]:
    """Return a motor's angle [rad] and its status: the high half of the first byte.

    Position follows in two bytes, high first. A register comes under the same identifier; as a
    position it would be two turns away.
    """
    if len(data) != 8 or data[0] & 0x0F != motor & 0x0F:
        raise ValueError(f"a frame that is no feedback of motor {motor}")
    if data[:2] == bytes([motor, 0]) and data[2] in REGISTERS:
        raise ValueError(f"a register of motor {motor}, which is no feedback")
    status = data[0] >> 4
    if status not in (0, ENABLED, *TROUBLES):
        raise ValueError(f"feedback of motor {motor} with status {status}")
    return int.from_bytes(data[1:3], "big") / COUNTS * 2 * PMAX - PMAX, status


def decode_query(data: bytes, motor: int, register: int = PMAX_REGISTER) -> float:
    """Return a motor's PMAX [rad], the angle that a full count stands for, or its serial number."""
    if len(data) != 8 or data[:4] != bytes([motor, 0, QUERY, register]):
        raise ValueError(f"a frame that is no answer of motor {motor}")
    (value,) = struct.unpack_from(FORMS[register], data, 4)
    return value


class Damiao(PolledDriver):
    """Damiao motors on a CAN bus."""

    resolution = 2 * PMAX / COUNTS

    def __init__(self, address: str, joint_names: ModelNames = None) -> None:
        bus = parse_can_address(address, ("rate", "ids", "signs"))
        super().__init__(f"the arm on {bus}")
        self._motors = bus.options.integers("ids", range(1, JOINTS + 1))
        self._signs = bus.options.signs(len(self._motors))
        if not all(0 < motor < ANSWERS for motor in self._motors):
            raise bus.options.wrong("ids", "a list of the motors' numbers, 1 to 15")
        self._joint_names = match_joints(joint_names, len(self._motors), "the arm")
        self._interval = 1 / bus.options.positive("rate", RATE)
        self._bus = CanBus(bus, tuple(ANSWERS + motor for motor in self._motors))
        self._fresh = FreshAnswers(self._bus.discard)
        with self._closed_on_error():
            # All motors answer, and count as they should.
            for motor in self._motors:
                until = clock.now() + FIRST_ANSWER_SECONDS
                try:
                    largest = self._ask(
                        motor, QUERY, PMAX_REGISTER, decode_query, until
                    )
                except ValueError as error:
                    raise Reason.UNREACHABLE(
                        f"{error} on {self._where}: is the arm's power on, and the bus at 1 Mbit/s?"
                    ) from None
                if largest != PMAX:
                    raise Reason.WRONG_ROBOT(
                        f"motor {motor} on {self._where} counts to {largest:g} rad, not {PMAX:g}: "
                        "its angles would be read wrong"
                    )
            self.identity = self._serial_numbers()

    def _receive(self, deadline: float) -> JointState:
        start = self._await_turn(deadline, self._interval)
        replies = [
            self._ask(motor, REFRESH, 0, decode_feedback) for motor in self._motors
        ]
        angles, statuses = zip(*replies, strict=True)
        self.status = ", ".join(
            f"motor {motor}: {TROUBLES[status]}"
            for motor, status in zip(self._motors, statuses, strict=True)
            if status in TROUBLES
        )
        if ENABLED in statuses:
            raise Reason.WRONG_MODE(
                f"a motor of {self._where} is enabled: end the program that moves the arm, and "
                "hold the arm, which falls when its motors are off"
            )
        position = tuple(s * q for s, q in zip(self._signs, angles, strict=True))
        return JointState((start + clock.now()) / 2, position)

    def _serial_numbers(self) -> str:
        """Return the motors' serial numbers; nothing where one tells none."""
        decode = partial(decode_query, register=SERIAL)
        try:
            numbers = [self._ask(m, QUERY, SERIAL, decode) for m in self._motors]
        except ValueError:
            return ""
        return f"serial numbers {', '.join(map(str, numbers))}"

    def _disconnect(self) -> None:
        self._bus.close()

    def _ask(
        self,
        motor: int,
        request: int,
        register: int,
        decode: Callable[[bytes, int], Decoded],
        until: float = 0.0,
    ) -> Decoded:
        """Return a motor's answer to a request; frames that are none are left out."""

        def ask() -> Decoded:
            self._bus.send(EVERYBODY, bytes([motor, 0, request, register, 0, 0, 0, 0]))
            deadline, bad = clock.now() + ANSWER_SECONDS, f"no answer of motor {motor}"
            while frame := self._bus.receive(deadline):
                if frame.arbitration_id == ANSWERS + motor:
                    try:
                        return decode(bytes(frame.data), motor)
                    except ValueError as error:
                        bad = str(error)
            raise ValueError(bad)

        return self._fresh.ask(ask, until)
