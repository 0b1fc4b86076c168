"""Messages of Kinova's Gen2 and JACO actuators, and the one that is ever sent.

A message has 20 bytes, little-endian, and no checksum::

    i16 command | u8 source | u8 destination | 16 bytes of data

Of all commands only GET_ACTUALPOSITION is sent; some others move the arm or rewrite its zeros.
"""

import math
import struct
from dataclasses import dataclass

GET_ACTUALPOSITION = 0x01
SEND_ACTUALPOSITION = 0x02
HOST = 0x00
FIRST_ACTUATOR = 0x10  # at the base; the others follow
MESSAGE = struct.Struct("<hBB16s")
VALUES = struct.Struct("<4f")
MESSAGE_BYTES = MESSAGE.size
LARGEST_DEGREES = 100 * 360.0  # some of these joints turn without end


@dataclass(frozen=True, slots=True)
class ActuatorReply:
    """The used part of an actuator's answer."""

    degrees: float
    torque: float
    """As the actuator gives it, presumably [N m]."""


def encode_poll(actuator: int) -> bytes:
    """Return the request for an actuator's position."""
    return MESSAGE.pack(GET_ACTUALPOSITION, HOST, actuator, bytes(VALUES.size))


def decode_reply(message: bytes, actuator: int) -> ActuatorReply:
    """Decode an answer: four float32, current, position [degrees], speed and torque."""
    if len(message) != MESSAGE.size:
        raise ValueError(f"a message of {len(message)} bytes where {MESSAGE.size} are expected")
    command, source, destination, data = MESSAGE.unpack(message)
    if (command, source, destination) != (SEND_ACTUALPOSITION, actuator, HOST):
        raise ValueError(f"a message that is no position of actuator 0x{actuator:02x}")
    current, degrees, speed, torque = VALUES.unpack(data)
    if not all(map(math.isfinite, (current, speed, torque))) or not (
        abs(degrees) <= LARGEST_DEGREES
    ):
        raise ValueError(f"impossible values from actuator 0x{actuator:02x}")
    return ActuatorReply(degrees, torque)
