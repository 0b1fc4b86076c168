"""KUKA's FRI messages: the controller's state, and the one reply that keeps it sending.

A message is protobuf. FRI 1.11 to 2.5 puts it into a datagram bare; FRI 2.7 frames it::

    u32 length | protobuf | u32 CRC-32 of the protobuf          (little-endian)

Read as a length, the first bytes of a bare message are larger than any datagram.
"""

import math
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from .. import JointValues, require_angles, require_finite

MONITORING_ID = 0x245142
COMMAND_ID = 0x34001
LARGEST_ANGLE = 2 * math.pi
LARGEST_MULTIPLIER = 1000  # a session that wants a reply more seldom would time out
FRAME_BYTES = 8  # length before, CRC-32 behind
LARGEST_DATAGRAM = 1500
HEADER_KEY = b"\x0a"  # every message begins with its header, field 1

VARINT, BYTES = 0, 2
FIXED = {1: 8, 5: 4}  # bytes of a number by its wire type
Fields = dict[int, list[tuple[int, Any]]]
"""Field number -> (wire type, value) of each occurrence: an int for a varint, else bytes."""


class Session(IntEnum):
    """State of an FRI session; from COMMANDING_WAIT on the controller expects to be moved."""

    IDLE = 0
    MONITORING_WAIT = 1
    MONITORING_READY = 2
    COMMANDING_WAIT = 3
    COMMANDING_ACTIVE = 4


@dataclass(frozen=True, slots=True)
class StateMessage:
    """The used part of a monitoring message."""

    sequence: int
    """Counts the messages of a session."""
    session: Session
    quality: str
    """Of the connection, in a word."""
    receive_multiplier: int
    """The controller expects a reply to each message of this many."""
    position: JointValues
    """Measured joint angles [rad]; empty when the message has none, as it may when idle."""
    torque: JointValues | None
    """Measured joint torques [N m]."""
    stamp: float
    """The controller's clock [s]; without one in the message, counted in send periods."""
    framed: bool
    """FRI 2.7 framing, in which the reply must come too."""


QUALITIES = ("poor", "fair", "good", "excellent")


def decode_message(datagram: bytes) -> StateMessage:
    """Decode a monitoring message."""
    size, body = int.from_bytes(datagram[:4], "little"), datagram
    in_frame = datagram[:1] != HEADER_KEY or size <= LARGEST_DATAGRAM
    if in_frame:
        body = datagram[4:-4]
        if len(datagram) < FRAME_BYTES or size != len(body):
            raise ValueError("a datagram that is no FRI message")
        if int.from_bytes(datagram[-4:], "little") != zlib.crc32(body):
            raise ValueError("an FRI message with a wrong checksum")
    message = _fields(body)
    header = _fields(_bytes(message, 1))
    if _varint(header, 1) != MONITORING_ID:
        raise ValueError("an FRI message that is no monitoring message")
    connection = _fields(_bytes(message, 4))
    quality = _varint(connection, 2)
    if quality >= len(QUALITIES):
        raise ValueError(f"an FRI message with connection quality {quality}")
    monitor = _fields(_bytes(message, 3, b""))
    position = _joint_values(monitor, 1)
    require_angles(position, LARGEST_ANGLE, "an FRI message")
    count = _varint(_fields(_bytes(message, 2, b"")), 1, len(position))
    if position and count != len(position):
        raise ValueError(
            f"an FRI message with {len(position)} angles for {count} joints"
        )
    torque = _joint_values(monitor, 2)
    if len(torque) not in (0, len(position)):
        raise ValueError(
            f"an FRI message with {len(position)} angles and {len(torque)} torques"
        )
    multiplier = _varint(connection, 4, 1)
    if multiplier > LARGEST_MULTIPLIER:
        raise ValueError(
            f"an FRI message that wants a reply only to each {multiplier}th"
        )
    sequence = _varint(header, 2)
    stamp = sequence * _varint(connection, 3, 1) * 1e-3
    if 15 in monitor:
        clock = _fields(_bytes(monitor, 15))
        seconds, nanoseconds = _varint(clock, 1), _varint(clock, 2)
        if seconds >= 1 << 32 or nanoseconds >= 10**9:
            raise ValueError(
                f"an FRI message with a stamp of {seconds} s and {nanoseconds} ns"
            )
        stamp = seconds + nanoseconds * 1e-9
    return StateMessage(
        sequence=sequence,
        session=Session(_varint(connection, 1)),
        quality=QUALITIES[quality],
        receive_multiplier=multiplier,
        position=position,
        torque=torque or None,
        stamp=stamp,
        framed=in_frame,
    )


def encode_reply(counter: int, reflected: int, in_frame: bool) -> bytes:
    """Return the counter-th reply, a header without a command, to the message of a sequence."""
    body = nested(1, numbers({1: COMMAND_ID, 2: counter, 3: reflected}))
    return framed(body) if in_frame else body


def framed(body: bytes) -> bytes:
    """Return a message in the frame of FRI 2.7."""
    return struct.pack("<I", len(body)) + body + struct.pack("<I", zlib.crc32(body))


def numbers(fields: Mapping[int, int]) -> bytes:
    """Return protobuf varint fields by number."""
    return b"".join(
        varint(number << 3 | VARINT) + varint(value) for number, value in fields.items()
    )


def nested(number: int, message: bytes) -> bytes:
    """Return a protobuf field that holds a message."""
    return varint(number << 3 | BYTES) + varint(len(message)) + message


def _joint_values(fields: Fields, number: int) -> JointValues:
    """Return a JointValues message: repeated doubles, packed or not; empty if it is absent."""
    values: list[float] = []
    for wire, value in _fields(_bytes(fields, number, b"")).get(1, []):
        if wire == VARINT or len(value) % 8:
            raise ValueError("an FRI message whose joint values are no doubles")
        values.extend(struct.unpack(f"<{len(value) // 8}d", value))
    require_finite(values, "an FRI message with joint values")
    return tuple(values)


def _fields(body: bytes) -> Fields:
    """Split a protobuf message into its fields; all of its bytes must belong to one."""
    fields: Fields = {}
    offset = 0
    while offset < len(body):
        key, offset = _decode_varint(body, offset)
        number, wire = key >> 3, key & 7
        if number == 0:
            raise ValueError("a message with a field 0")
        if wire not in (VARINT, BYTES, *FIXED):
            raise ValueError(f"a message with a field of unknown wire type {wire}")
        value: Any = FIXED.get(wire)
        if value is None:
            value, offset = _decode_varint(body, offset)
        if wire != VARINT:
            start = offset
            offset += value
            value = body[start:offset]
            if offset > len(body):
                raise ValueError("a message that ends within a field")
        fields.setdefault(number, []).append((wire, value))
    return fields


def _bytes(fields: Fields, number: int, default: bytes | None = None) -> bytes:
    return _single(fields, number, BYTES, default)


def _varint(fields: Fields, number: int, default: int | None = None) -> int:
    return _single(fields, number, VARINT, default)


def _single(fields: Fields, number: int, wire: int, default: Any) -> Any:
    occurrences = fields.get(number, [])
    if not occurrences and default is not None:
        return default
    if len(occurrences) != 1 or occurrences[0][0] != wire:
        raise ValueError(f"a message without a proper field {number}")
    return occurrences[0][1]


def _decode_varint(body: bytes, offset: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        if offset >= len(body) or shift > 63:
            raise ValueError("a message that ends within a number")
        byte = body[offset]
        value |= (byte & 0x7F) << shift
        offset += 1
        shift += 7
        if byte < 0x80:
            return value, offset


def varint(value: int) -> bytes:
    """Return a protobuf varint."""
    encoded = bytearray()
    while value > 0x7F:
        encoded.append(value & 0x7F | 0x80)
        value >>= 7
    encoded.append(value)
    return bytes(encoded)
