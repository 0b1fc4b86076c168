"""Damiao motors on a CAN bus: OpenArm, whose joints are asked where they are while they are off.

Two requests are sent, neither of which enables a motor::

    7FF: motor 00 CC 00 00 00 00 00       where are you?
    7FF: motor 00 33 15 00 00 00 00       how large is PMAX, the angle that a full count stands for?

A motor answers on its own identifier, 10 (hex) above its number::

    status * 16 + motor | position, 2 bytes, high first | velocity, torque, 3 bytes | temperatures

    angle = position / 65535 * 2 PMAX - PMAX

PMAX is 12.5 rad in all motors of these arms; another one would look like a wrong arm, and is
refused. So is a motor that is enabled: another program moves the arm. Efforts are None, since a
motor that is off carries nothing. Stamps are the time in the middle between the first request and
the last answer.

Address: ``[INTERFACE/]CHANNEL[?rate=HZ&ids=1,2,..&signs=1,-1,..]``, the bus as in
:mod:`mukca.drivers.transport.can_bus`.
"""

import struct
from collections.abc import Sequence

import can

from .. import DriverError, JointState, PolledDriver, Reason, clock, match_joints
from ..transport import open_bus, parse_can_address

JOINTS = 7
EVERYBODY = 0x7FF
ANSWERS = 0x10  # above a motor's number
REFRESH, QUERY, PMAX_REGISTER = 0xCC, 0x33, 0x15
PMAX = 12.5  # rad
COUNTS = 65535
ENABLED = 1
TROUBLES = {
    8: "over-voltage",
    9: "under-voltage",
    10: "over-current",
    11: "too hot",
    12: "rotor too hot",
    13: "lost communication",
    14: "overload",
}
RATE = 100.0  # Hz
ANSWER_SECONDS = 0.1
FIRST_ANSWER_SECONDS = 1.0


def encode_refresh(motor: int) -> bytes:
    """Return the request for a motor's feedback."""
    return bytes([motor, 0, REFRESH, 0, 0, 0, 0, 0])


def encode_query(motor: int) -> bytes:
    """Return the request for a motor's PMAX."""
    return bytes([motor, 0, QUERY, PMAX_REGISTER, 0, 0, 0, 0])


def decode_feedback(data: bytes, motor: int) -> tuple[float, int]:
    """Return a motor's angle [rad] and its status.

    Raises:
        ValueError: Another length, another motor, or a status that there is not.
    """
    if len(data) != 8 or data[0] & 0x0F != motor & 0x0F:
        raise ValueError(f"a frame that is no feedback of motor {motor}")
    status = data[0] >> 4
    if status not in (0, ENABLED, *TROUBLES):
        raise ValueError(f"feedback of motor {motor} with status {status}")
    return int.from_bytes(data[1:3], "big") / COUNTS * 2 * PMAX - PMAX, status


def decode_query(data: bytes, motor: int) -> float:
    """Return a motor's PMAX [rad].

    Raises:
        ValueError: It is no such answer.
    """
    if len(data) != 8 or data[:4] != bytes([motor, 0, QUERY, PMAX_REGISTER]):
        raise ValueError(f"a frame that is no answer of motor {motor}")
    return float(struct.unpack_from("<f", data, 4)[0])


class Damiao(PolledDriver):
    """Damiao motors on a CAN bus."""

    resolution = 2 * PMAX / COUNTS

    def __init__(self, address: str, joint_names: Sequence[str] | None = None) -> None:
        bus = parse_can_address(address, ("rate", "ids", "signs"))
        super().__init__(f"the arm on {bus}")
        self._motors = bus.options.integers("ids", range(1, JOINTS + 1))
        self._signs = bus.options.integers("signs", [1] * len(self._motors))
        if not all(0 < motor < ANSWERS for motor in self._motors):
            raise bus.options.wrong("ids", "a list of the motors' numbers, 1 to 15")
        if len(self._signs) != len(self._motors) or not set(self._signs) <= {1, -1}:
            raise bus.options.wrong("signs", "1 or -1 for each joint")
        self._joint_names = match_joints(joint_names, len(self._motors), "the arm")
        self._interval = 1 / bus.options.positive("rate", RATE)
        self._bus = open_bus(bus, tuple(ANSWERS + motor for motor in self._motors))
        with self._closed_on_error():
            self._inspect()

    def _receive(self, deadline: float) -> JointState:
        self._await_turn(deadline)
        start = clock.now()
        self._next_poll = start + self._interval
        angles, statuses = zip(*self._ask_all(), strict=True)
        self.status = ", ".join(
            f"motor {motor}: {TROUBLES[status]}"
            for motor, status in zip(self._motors, statuses, strict=True)
            if status in TROUBLES
        )
        if ENABLED in statuses:
            raise DriverError(
                Reason.WRONG_MODE,
                f"a motor of {self._where} is enabled: end the program that moves the arm, and "
                "hold the arm, which falls when its motors are off",
            )
        position = tuple(s * q for s, q in zip(self._signs, angles, strict=True))
        return JointState((start + clock.now()) / 2, position)

    def _disconnect(self) -> None:
        self._bus.shutdown()

    def _inspect(self) -> None:
        """See that all motors answer, and count as they should."""
        for motor in self._motors:
            try:
                largest = self._await_query(motor)
            except ValueError as error:
                raise DriverError(
                    Reason.UNREACHABLE,
                    f"{error} on {self._where}: is the arm's power on, and the bus at 1 Mbit/s?",
                ) from None
            if largest != PMAX:
                raise DriverError(
                    Reason.WRONG_ROBOT,
                    f"motor {motor} on {self._where} counts to {largest:g} rad, not {PMAX:g}: its "
                    "angles would be read wrong",
                )

    def _await_query(self, motor: int) -> float:
        end = clock.now() + FIRST_ANSWER_SECONDS
        while True:
            self._send(encode_query(motor))
            try:
                for data in self._answers(motor):
                    if data[2:4] == bytes([QUERY, PMAX_REGISTER]):
                        return decode_query(data, motor)
                raise ValueError(f"no answer of motor {motor}")
            except ValueError:
                if clock.now() > end:
                    raise

    def _ask_all(self) -> list[tuple[float, int]]:
        """Return all motors' angles and statuses, one after the other.

        Raises:
            ValueError: A motor did not answer.
        """
        replies: list[tuple[float, int]] = []
        for motor in self._motors:
            self._send(encode_refresh(motor))
            data = next(iter(self._answers(motor)), None)
            if data is None:
                raise ValueError(f"no answer of motor {motor}")
            replies.append(decode_feedback(data, motor))
        return replies

    def _answers(self, motor: int) -> Sequence[bytes]:
        """Return the next frame of a motor, none if it does not come; others are dropped."""
        until = clock.now() + ANSWER_SECONDS
        try:
            while (frame := self._bus.recv(max(0.0, until - clock.now()))) is not None:
                sound = not (frame.is_extended_id or frame.is_error_frame or frame.is_remote_frame)
                if sound and frame.arbitration_id == ANSWERS + motor:
                    return [bytes(frame.data)]
        except (can.CanError, OSError, ValueError) as error:
            raise DriverError(Reason.UNREACHABLE, f"{self._where} is lost: {error}") from None
        return []

    def _send(self, data: bytes) -> None:
        try:
            self._bus.send(can.Message(arbitration_id=EVERYBODY, data=data, is_extended_id=False))
        except (can.CanError, OSError, ValueError) as error:
            raise DriverError(Reason.UNREACHABLE, f"{self._where} is lost: {error}") from None
