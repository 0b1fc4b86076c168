"""No adapter ever sends anything but what it takes to be sent the state.

The emulators note every byte that they receive, here also while they misbehave; what is allowed
is spelled out byte by byte, apart from the code that sends it.
"""

import re
import struct

import pytest
from emulation import emulated
from kortex_stand_in import kortex_arm
from rosbridge import ARM, rosbridge

from mukca.drivers import DriverError, Reconnecting, open_driver

pytestmark = pytest.mark.slow

VARINT = rb"[\x80-\xff]{0,4}[\x00-\x7f]"
FRI_HEADER = re.compile(
    rb"\x0a([\x08-\x12])(\x08\x81\x80\x0d\x10" + VARINT + rb"\x18" + VARINT + rb")", re.DOTALL
)


def allowed_by_franka(channel, message):
    """A connect request: command 0, 16 bytes, a version, a port. Never a datagram."""
    command, _, size = struct.unpack_from("<III", message)
    return channel == "tcp" and (command, size, len(message)) == (0, 16, 16)


def allowed_by_kuka(channel, message):
    """An FRI command message of a header alone, bare or framed."""
    if message[2:4] == b"\0\0":  # a length
        message = message[4:-4]
    found = FRI_HEADER.fullmatch(message)
    return found is not None and found[1][0] == len(found[2])


def allowed_by_ur(channel, message):
    """The four requests: protocol and controller version, outputs, start."""
    requests = []
    while message:
        size = int.from_bytes(message[:2], "big")
        requests.append(message[2:size])
        message = message[size:]
    return all(
        request in (b"V\0\2", b"v", b"S")
        or re.fullmatch(rb"O.{8}timestamp,actual_q,robot_mode,safety_mode", request, re.DOTALL)
        for request in requests
    )


def allowed_by_kinova(channel, message):
    """Command 1, from the host, to an actuator, without data."""
    expected = [b"\1\0\0" + bytes([actuator]) + bytes(16) for actuator in range(0x10, 0x16)]
    return channel == "line" and message in expected


def allowed_by_feetech(channel, message):
    """Sync read of model, torque, homing offset and position, servos 1 to 5; the sum is right."""
    registers = (b"\x03\x02", b"\x28\x01", b"\x1f\x02", b"\x38\x02")
    bodies = [b"\xfe\x09\x82" + register + b"\1\2\3\4\5" for register in registers]
    return channel == "line" and message in [
        b"\xff\xff" + body + bytes([0xFF - sum(body) % 256]) for body in bodies
    ]


def allowed_by_dynamixel(channel, message):
    """The same of protocol 2.0, servos 1, 2, 4, 6, 7 and 8."""
    registers = (b"\0\0\2\0", b"\x40\0\1\0", b"\x14\0\4\0", b"\x84\0\4\0")
    heads = [b"\xff\xff\xfd\0\xfe\x0d\0\x82" + register for register in registers]
    return channel == "line" and message[:-2] in [head + b"\1\2\4\6\7\x08" for head in heads]


def allowed_by_damiao(channel, message):
    """Refresh, and the query for PMAX, to motors 1 to 7."""
    asked = message[1:] in (b"\0\xcc" + bytes(5), b"\0\x33\x15" + bytes(4))
    return channel == "7ff" and asked and message[0] in range(1, 8)


def allowed_by_piper(channel, message):
    """Nothing at all."""
    return False


ALLOWED = {
    "franka": allowed_by_franka,
    "kuka": allowed_by_kuka,
    "ur": allowed_by_ur,
    "kinova": allowed_by_kinova,
    "piper": allowed_by_piper,
    "damiao": allowed_by_damiao,
    "xarm": allowed_by_piper,
    "feetech": allowed_by_feetech,
    "dynamixel": allowed_by_dynamixel,
}
POLLED = ("damiao", "kinova", "feetech", "dynamixel")
FAULTS = ("drop:0.05", "duplicate:0.05", "garble:0.02", "silent@1+0.5", "hangup@2+0.5")


@pytest.mark.parametrize("faults", [(), FAULTS], ids=["well", "ill"])
@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("franka", "3"),
        ("franka", "10"),
        ("kuka", "1.15"),
        ("kuka", "2.7"),
        ("ur", "5.11"),
        ("kinova", "serial"),
        ("kinova", "can"),
        ("piper", "1"),
        ("damiao", "openarm"),
        ("xarm", "xarm6"),
        ("xarm", "xarm6-old"),
        ("feetech", "so101"),
        ("dynamixel", "vx300s"),
    ],
)
def test_nothing_else_is_sent(name, version, faults, tmp_path):
    words = [word for fault in faults for word in ("--fault", fault)]
    with emulated(name, tmp_path, "--version", version, *words) as emulation:
        with Reconnecting(lambda: open_driver(name, emulation.address)) as driver:
            states = 0
            while states < (60 if name in POLLED else 500):
                try:
                    driver.read(1)
                    states += 1
                except DriverError:
                    continue
        emulation.stop()
        received = emulation.received()
    assert bool(received) == (name not in ("piper", "xarm")), "the journal noted nothing"
    for channel, message in received:
        assert ALLOWED[name](channel, message), f"{channel}: {message.hex(' ')}"


@pytest.mark.parametrize(
    ("name", "channel", "message"),
    [
        ("franka", "tcp", struct.pack("<III", 1, 1, 16) + bytes(4)),  # Move
        ("franka", "udp", bytes(100)),  # RobotCommand
        ("kuka", "udp", bytes.fromhex("0a080881800d10001805120a0a080900000000000000")),
        ("ur", "tcp", b"\0\x0dI" + bytes(10)),  # an input
        ("kinova", "line", struct.pack("<hBB", 0x26, 0, 0x10) + bytes(16)),  # joint zero
        ("damiao", "001", b"\xff" * 7 + b"\xfc"),  # enable
        ("damiao", "7ff", bytes.fromhex("0100551500004841")),  # write a register
        ("xarm", "30000", b"\0"),
        ("piper", "151", bytes(8)),  # motion control
        ("feetech", "line", bytes.fromhex("ffff0104032801ce")),  # torque on
        ("feetech", "line", bytes.fromhex("fffffe0982210201020304050d")),  # other registers
        ("dynamixel", "line", bytes.fromhex("fffffd000106000340000 1dB66".replace(" ", ""))),
    ],
)
def test_commands_would_be_found(name, channel, message):
    assert not ALLOWED[name](channel, message)


def test_kortex_is_asked_for_feedback_alone():
    with kortex_arm() as arm, open_driver("kinova", arm.address) as driver:
        for _ in range(20):
            driver.read(1)
    assert set(arm.calls[2:-2]) == {"RefreshFeedback"}
    assert arm.calls[:2] == ["connect", "CreateSession"]
    assert arm.calls[-2:] == ["CloseSession", "disconnect"]


def test_ros_is_subscribed_to_alone():
    with rosbridge() as bridge:
        with open_driver("ros", bridge.address, ARM) as driver:
            for _ in range(20):
                driver.read(1)
        operations = [(message["op"], message["topic"]) for message in bridge.received]
    assert set(operations) <= {("subscribe", "/joint_states"), ("unsubscribe", "/joint_states")}
    assert operations[0][0] == "subscribe"
