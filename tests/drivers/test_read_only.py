"""No adapter ever sends anything but what it takes to be sent the state.

The emulators note every byte that they receive, here also while they misbehave; what is allowed
is spelled out byte by byte, apart from the code that sends it.
"""

import json
import re
from contextlib import suppress
from pathlib import Path

import pytest
from cases import by_table
from emulation import emulated
from kortex_stand_in import kortex_arm
from rosbridge import ARM, rosbridge

from mukca.drivers import DriverError, Reconnecting, clock, open_driver
from mukca.tools.cli.commands import EMULATORS

pytestmark = [pytest.mark.slow, pytest.mark.waits]

VARINT = rb"[\x80-\xff]{0,4}[\x00-\x7f]"
FEETECH = [
    b"\xfe\x09\x82" + register + b"\1\2\3\4\5"  # sync read of servos 1 to 5
    for register in (b"\x03\x02", b"\x28\x01", b"\x1f\x02", b"\x38\x02")
]
ALLOWED = {
    # a connect request: command 0, 16 bytes, a version, a port; never a datagram
    "franka": rb"tcp:\0{4}.{4}\x10\0{3}.{4}",
    # an FRI command message of a header alone, bare or framed by its length and a checksum
    "kuka": rb"udp:(?P<length>..\0\0)?\x0a(?P<size>[\x08-\x12])(?P<header>\x08\x81\x80\x0d\x10"
    + VARINT + rb"\x18" + VARINT + rb")(?(length).{4})",
    # the four requests: protocol and controller version, outputs, start
    "ur": rb"tcp:(\0\x05V\0\x02|\0\x03[vS]|\0.O.{8}timestamp,actual_q,robot_mode,safety_mode)+",
    # command 1, from the host, to an actuator, without data
    # on a CAN bus by ISO-TP: its 20 bytes in three frames, and leave to send the answer
    "kinova": rb"(?:line|can):\x01\0\0[\x10-\x15]\0{16}"
    rb"|700:(\x10\x14\x01\0\0[\x10-\x15]\0\0|[\x21\x22]\0{7}|\x30\x08\0)",
    # model, torque, homing offset and position; the sum is right
    "feetech": b"line:\xff\xff(?:" + b"|".join(
        re.escape(body + bytes([0xFF - sum(body) % 256])) for body in FEETECH
    ) + b")",
    # the same of protocol 2.0, servos 1, 2, 4, 6, 7 and 8
    "dynamixel": rb"line:\xff\xff\xfd\0\xfe\x0d\0\x82"
    rb"(?:\0\0\x02\0|\x40\0\x01\0|\x14\0\x04\0|\x84\0\x04\0)\x01\x02\x04\x06\x07\x08..",
    # refresh, and the queries for PMAX and the serial number, to motors 1 to 7
    "damiao": rb"7ff:[\x01-\x07]\0(?:\xcc\0{5}|\x33[\x15\x0f]\0{4})",
}  # fmt: skip
"""Channel and bytes of each message that may be sent; to a Piper and to an xArm none."""


def allowed(name, channel, message):
    expected = ALLOWED.get(name, rb"(?!)")
    found = re.fullmatch(expected, channel.encode() + b":" + message, re.DOTALL)
    return bool(found) and (name != "kuka" or found["size"][0] == len(found["header"]))


def test_every_emulator_is_tried():
    tables = json.loads(Path(__file__).with_suffix(".json").read_text())
    for table in tables.values():
        assert {name for name, *_ in table} == set(EMULATORS)


FAULTS = ("drop:0.05", "duplicate:0.05", "garble:0.02", "silent@0.4+0.4", "hangup@1+0.4")
LAST = 2.0
"""By then all faults are over, and the arm was reached again [s]."""


@pytest.mark.parametrize("faults", [(), FAULTS], ids=["well", "ill"])
@by_table("name", "version")
def test_nothing_else_is_sent(name, version, faults, tmp_path):
    words = [word for fault in faults for word in ("--fault", fault)]
    with emulated(name, tmp_path, "--version", version, *words) as emulation:
        with Reconnecting(lambda: open_driver(name, emulation.address)) as driver:
            end, states = clock.now() + LAST, 0
            while clock.now() < end or states < 20:
                with suppress(DriverError):
                    driver.read(1)
                    states += 1
        emulation.stop()
        received = emulation.received()
    assert bool(received) == (name in ALLOWED), "the journal noted nothing"
    for channel, message in received:
        assert allowed(name, channel, message), f"{channel}: {message.hex(' ')}"


@by_table("name", "command", "channel", "message")
def test_commands_would_be_found(name, command, channel, message):
    assert not allowed(name, channel, bytes.fromhex(message)), command


def test_kortex_is_asked_for_feedback_and_its_number_alone():
    with kortex_arm() as arm, open_driver("kinova", arm.address) as driver:
        for _ in range(20):
            driver.read(1)
    assert arm.calls.pop(3) == "GetSerialNumber"
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
