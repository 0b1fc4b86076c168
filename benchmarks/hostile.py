"""Feed a million hostile messages to the decoders of all protocols.

::

    python benchmarks/hostile.py [--count 1000000] [--seed 0]

A third are random bytes, of any length or of a right one; a third are good messages cut short or
grown; a third are good messages with some bytes changed. A decoder may raise ValueError and
nothing else. What it takes must be plausible, of the right length, and bear the right marks
(identifiers, flags, checksum). The time of each is printed against that of a good message.
"""

import argparse
import math
import random
import struct
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field

from mukca.drivers import JointState
from mukca.drivers.arms import damiao, xarm
from mukca.drivers.arms.franka import LAYOUTS, decode_state
from mukca.drivers.arms.fri import decode_message
from mukca.drivers.arms.kinova_bus import decode_reply
from mukca.drivers.arms.piper import decode_frame
from mukca.drivers.arms.servos import dynamixel, feetech
from mukca.drivers.arms.ur import Recipe, take_package
from mukca.tools.emulators.servos import crc16
from mukca.tools.emulators.udp_arms import encode_message, encode_state

Q = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7)
STATE = JointState(0.0, Q, Q)
RECIPE = Recipe(1, effort=False)


@dataclass
class Protocol:
    """A decoder, a good message, and what must hold of a message that it takes."""

    name: str
    good: bytes
    decode: Callable[[bytes], tuple[float, ...]]
    sound: Callable[[bytes], bool]
    largest: float = 2 * math.pi
    taken: int = 0
    seen: int = 0
    slowest: float = 0.0
    spent: float = field(default=0.0)


def decode_rtde(data: bytes) -> tuple[float, ...]:
    """Take a package off a stream and decode it; wrist 3 may turn without end."""
    package = take_package(bytearray(data))
    if package is None or package[0] != ord("U"):
        raise ValueError("no data")
    *position, wrist_3 = RECIPE.decode(package[1])[0].position
    return (*position, 0.0 * wrist_3)


def sound_franka(data: bytes) -> bool:
    count, tail = {2085: (37, 9), 2341: (37, 9), 2373: (41, 9), 1377: (41, 5)}[
        len(data)
    ]
    flags = data[-tail - 2 * count : -tail]
    return len(data) in LAYOUTS and max(flags) <= 1 and data[-tail] <= 6


def sound_framed(data: bytes) -> bool:
    length, checksum = (
        int.from_bytes(data[:4], "little"),
        int.from_bytes(data[-4:], "little"),
    )
    return length == len(data) - 8 and checksum == zlib.crc32(data[4:-4])


def protocols() -> list[Protocol]:
    """Return all wire formats that are read."""
    rtde = struct.pack(">HBBd6dii", 68, ord("U"), 1, 2.5, *Q[:6], 7, 1)
    found = [
        Protocol(
            f"franka {v}", encode_state(v, 5, STATE), franka_position, sound_franka
        )
        for v in (3, 4, 5, 10)
    ]
    for version in ("1.15", "2.5", "2.7"):
        good = encode_message(version, (0x245142, 7, 6), (2, 3, 5, 1), STATE, 99)
        framed = version == "2.7"
        sound = (
            sound_framed
            if framed
            else lambda data: b"\x08\xc2\xa2\x91\x01" in data[:12]
        )
        found.append(Protocol(f"fri {version}", good, fri_position, sound))
    found.append(
        Protocol(
            "rtde", rtde, decode_rtde, lambda d: d[:4] == rtde[:4], largest=4 * math.pi
        )
    )
    reply = struct.pack("<hBB4f", 2, 0x12, 0, 0.5, 90.0, 0.0, 3.0)
    found.append(
        Protocol(
            "kinova",
            reply,
            kinova_position,
            lambda d: d[:4] == reply[:4],
            largest=36_000,
        )
    )
    frame = struct.pack(">ii", 90_000, -45_000)
    found.append(Protocol("piper", frame, decode_frame, lambda data: len(data) == 8))
    sts = bytes.fromhex("ffff0104000008f2")
    found.append(Protocol("feetech", sts, feetech_position, sound_sts, largest=65535))
    x = bytes.fromhex("fffffd000108005500000800001c38")
    found.append(Protocol("dynamixel", x, dynamixel_position, sound_x, largest=2**32))
    real = (87).to_bytes(4, "big") + bytes(3) + struct.pack("<7f", *Q) + bytes(52)
    found.append(
        Protocol(
            "xarm 30003",
            real,
            xarm_position,
            lambda d: int.from_bytes(d[:4], "big") == len(d),
            largest=6.5,
        )
    )
    feedback = bytes.fromhex("03851e7ff825191b")
    found.append(
        Protocol("damiao", feedback, damiao_position, sound_damiao, largest=12.5)
    )
    return found


def damiao_position(data: bytes) -> tuple[float, ...]:
    return (damiao.decode_feedback(data, 3)[0],)


def sound_damiao(data: bytes) -> bool:
    return len(data) == 8 and data[0] & 0x0F == 3


def xarm_position(data: bytes) -> tuple[float, ...]:
    report = xarm.take_report(bytearray(data))
    if report is None or len(report) != len(data):
        raise ValueError("no report")
    return xarm.decode_report(report, xarm.REAL).angles


def sound_xarm(data: bytes) -> bool:
    return int.from_bytes(data[:4], "big") == len(data) >= 87


def feetech_position(data: bytes) -> tuple[float, ...]:
    answer = feetech.decode_answer(data)
    return (int.from_bytes(answer.data[:2], "little"),)


def sound_sts(data: bytes) -> bool:
    return sum(data[2:]) & 0xFF == 0xFF and data[3] == len(data) - 4 and data[2] < 0xFE


def dynamixel_position(data: bytes) -> tuple[float, ...]:
    answer = dynamixel.decode_answer(data)
    return (int.from_bytes(answer.data[:4], "little"),)


def sound_x(data: bytes) -> bool:
    return crc16(data[:-2]) == int.from_bytes(data[-2:], "little") and data[7] == 0x55


def franka_position(data: bytes) -> tuple[float, ...]:
    return decode_state(data)[0].position


def fri_position(data: bytes) -> tuple[float, ...]:
    return decode_message(data).position


def kinova_position(data: bytes) -> tuple[float, ...]:
    degrees, torque = decode_reply(data, 0x12)
    return degrees, torque * 0


def hostile(good: bytes, source: random.Random) -> bytes:
    """Return a hostile message."""
    kind = source.randrange(6)
    if kind == 0:
        return source.randbytes(source.randrange(2 * len(good)))
    if kind == 1:
        return source.randbytes(len(good))
    if kind == 2:
        return good[: source.randrange(len(good))]
    if kind == 3:
        return good + source.randbytes(source.randrange(1, 40))
    data = bytearray(good)
    for _ in range(1 if kind == 4 else source.randrange(1, 30)):
        data[source.randrange(len(data))] = source.randrange(256)
    return bytes(data)


def attack(protocol: Protocol, data: bytes) -> None:
    """Give one message to a decoder, and check what it makes of it."""
    protocol.seen += 1
    start = time.perf_counter()
    try:
        position = protocol.decode(data)
    except ValueError:
        return
    finally:
        taken = time.perf_counter() - start
        protocol.spent += taken
        protocol.slowest = max(protocol.slowest, taken)
    protocol.taken += 1
    plausible = all(math.isfinite(q) and abs(q) <= protocol.largest for q in position)
    if not plausible or not protocol.sound(data):
        raise SystemExit(f"{protocol.name} took {data.hex()} as {position}")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    source = random.Random(arguments.seed)
    victims = protocols()
    for number in range(arguments.count):
        victim = victims[number % len(victims)]
        attack(victim, hostile(victim.good, source))
    print(
        f"{'protocol':10} {'messages':>9} {'taken':>8} {'mean':>9} {'x good':>7} {'slowest':>10}"
    )
    for victim in victims:
        start = time.perf_counter()
        for _ in range(1000):
            victim.decode(victim.good)
        good = (time.perf_counter() - start) / 1000
        mean = victim.spent / victim.seen
        print(
            f"{victim.name:10} {victim.seen:9} {victim.taken:8} {1e6 * mean:6.1f} us "
            f"{mean / good:7.2f} {1e3 * victim.slowest:7.2f} ms"
        )
    print(
        f"{arguments.count} hostile messages: nothing but ValueError, no implausible angle"
    )


if __name__ == "__main__":
    main()
