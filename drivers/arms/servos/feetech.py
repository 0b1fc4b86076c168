"""Feetech STS and SMS servos: SO-100 and SO-101, and arms of one's own.

A packet, and a servo's answer; the checksum is the inverted sum of all between::

    FF FF | servo | length | 82, first register, bytes, servos .. | checksum     (servo FE: all)
    FF FF | servo | length | error | registers ..                 | checksum

Address: ``PORT[?arm=so101|so100&calibration=FILE&rate=HZ&baud=..&ids=..&signs=..&zeros=..]``.
"""

from collections.abc import Sequence

from .joint_maps import maps_of
from .servo_arm import Answer, Make, Register, ServoArm

HEADER = b"\xff\xff"
EVERYBODY = 0xFE
SYNC_READ = 0x82
AROUND = 6  # bytes of an answer beside the registers
ERRORS = {
    1: "voltage",
    2: "angle sensor",
    4: "too hot",
    8: "over-current",
    32: "overload",
}
MODELS = {777: "STS3215", 2825: "STS3250", 11272: "SM8512BL"}


def encode_request(register: int, count: int, servos: Sequence[int]) -> bytes:
    """Return the request for the servos' registers."""
    body = bytes([EVERYBODY, len(servos) + 4, SYNC_READ, register, count, *servos])
    return HEADER + body + bytes([_checksum(body)])


def decode_answer(packet: bytes) -> Answer:
    """Decode a servo's answer."""
    if len(packet) < AROUND or packet[:2] != HEADER or packet[3] != len(packet) - 4:
        raise ValueError("no answer of a servo")
    servo, error = packet[2], packet[4]
    if servo >= EVERYBODY or error > 0x7F:
        raise ValueError("an answer of no servo")
    if packet[-1] != _checksum(packet[2:-1]):
        raise ValueError("an answer with a wrong checksum")
    return Answer(servo, error, packet[5:-1])


def _checksum(body: bytes) -> int:
    return ~sum(body) & 0xFF


class Feetech(ServoArm):
    """An arm of Feetech servos."""

    make = Make(
        encode_request=encode_request,
        header=HEADER,
        least_bytes=AROUND,
        size=lambda _, count: count + AROUND,
        decode_answer=decode_answer,
        arms=maps_of("feetech"),
        default="so101",
        models=MODELS,
        model=Register(3, 2),
        torque=Register(40, 1),
        homing=Register(31, 2, sign_bit=11),
        position=Register(56, 2, sign_bit=15),
        least=0,
        most=4095,
        troubles=lambda error: [name for bit, name in ERRORS.items() if error & bit],
    )
