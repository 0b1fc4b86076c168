"""Dynamixel X-series servos by protocol 2.0: ViperX, WidowX, Koch, OMX, and arms of one's own.

A packet, and a servo's answer; lowest byte first, ``FF FF FD`` within is ``FF FF FD FD``::

    FF FF FD 00 | servo | length | 82, first register, bytes, servos .. | CRC-16    (servo FE: all)
    FF FF FD 00 | servo | length | 55, error, registers ..              | CRC-16

Address: ``PORT?arm=vx300s|wx250s|koch|omx``, and options as for :mod:`.feetech`.
"""

import struct
from collections.abc import Sequence

from .joint_maps import maps_of
from .servo_arm import Answer, Make, Register, ServoArm

HEADER = b"\xff\xff\xfd\x00"
MARK, STUFFED = b"\xff\xff\xfd", b"\xff\xff\xfd\xfd"
EVERYBODY = 0xFE
SYNC_READ = 0x82
STATUS = 0x55
FRONT = 7  # bytes up to the length
AROUND = 4  # bytes that the length counts beside the registers
ALERT, CODE = 0x80, 0x7F
TURNS = 256  # either way, in the servo's widest mode


def encode_request(register: int, count: int, servos: Sequence[int]) -> bytes:
    """Return the request for the servos' registers."""
    content = struct.pack("<BHH", SYNC_READ, register, count) + bytes(servos)
    packet = HEADER + struct.pack("<BH", EVERYBODY, len(content) + 2) + content
    return packet + struct.pack("<H", crc16(packet))


def _size(received: bytearray, count: int) -> int:
    """Return the size of the answer that comes first; stuffing may make it longer."""
    length = int.from_bytes(received[5:FRONT], "little")
    shortest = count + AROUND
    return FRONT + length if shortest <= length <= shortest + count // len(MARK) else 0


def decode_answer(packet: bytes) -> Answer:
    """Decode a servo's answer."""
    if len(packet) < FRONT + AROUND or packet[:4] != HEADER:
        raise ValueError("no answer of a servo")
    if int.from_bytes(packet[5:FRONT], "little") != len(packet) - FRONT:
        raise ValueError("an answer of another length")
    if int.from_bytes(packet[-2:], "little") != crc16(packet[:-2]):
        raise ValueError("an answer with a wrong checksum")
    servo, content = packet[4], packet[FRONT:-2].replace(STUFFED, MARK)
    if servo >= EVERYBODY - 1 or content[0] != STATUS or len(content) < 2:
        raise ValueError("a packet that is no answer")
    return Answer(servo, content[1], content[2:])


def crc16(data: bytes) -> int:
    """Return the CRC-16 with polynomial 0x8005, not reflected, from 0 on."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = crc << 1 ^ (0x18005 if crc & 0x8000 else 0)
    return crc


def _troubles(error: int) -> list[str]:
    if error & CODE:
        raise ValueError(f"error {error & CODE} instead of what was asked for")
    return ["hardware alert"] if error & ALERT else []


class Dynamixel(ServoArm):
    """An arm of Dynamixel servos."""

    make = Make(
        encode_request=encode_request,
        header=HEADER,
        least_bytes=FRONT,
        size=_size,
        decode_answer=decode_answer,
        arms=maps_of("dynamixel"),
        default=None,
        models=range(1000, 1300),  # the X series
        model=Register(0, 2),
        torque=Register(64, 1),
        homing=Register(20, 4, signed=True),
        position=Register(132, 4, signed=True),
        least=-TURNS * 4096,
        most=TURNS * 4096,
        troubles=_troubles,
    )
