"""Clients that others wrote read our emulators: both speak the controllers' real bytes.

Each client runs in a program of its own, since the C++ ones hold the interpreter in their
constructors. It prints what it read; the emulator's journal tells what was sent.
"""

import importlib.util
import json
import math
import socket
import struct
import subprocess
import sys

import pytest
from emulator_programs import emulated_program
from terminal_session import PATIENCE

from mukca import open_driver

pytestmark = [pytest.mark.slow, pytest.mark.waits]

LIBFRANKA = """
import json, sys
import {module} as library
robot = library.Robot(sys.argv[1], library.RealtimeConfig.kIgnore)
states = [robot.read_once() for _ in range(200)]
print(json.dumps([
    {{"number": round(state.time.to_sec() * 1000), "q": list(state.q), "tau_J": list(state.tau_J),
      "mode": str(state.robot_mode)}}
    for state in states
]))
"""

UR_RTDE = """
import json, sys, time
from rtde_receive import RTDEReceiveInterface
robot = RTDEReceiveInterface(sys.argv[1], {frequency}, ["timestamp", "actual_q", "target_moment"])
states = []
while len(states) < 50:
    before, q, torque = robot.getTimestamp(), robot.getActualQ(), robot.getTargetMoment()
    if robot.getTimestamp() == before:
        states.append([before, q, torque])
    time.sleep(0.003)
robot.disconnect()
print(json.dumps(states))
"""

PIPER = """
import json, sys, can
from piper_sdk import C_PiperParserV2, PiperMessage, ArmMsgType
bus = can.Bus(interface="udp_multicast", channel="239.74.163.2", port=int(sys.argv[1]), hop_limit=0)
parser, turns, turn = C_PiperParserV2(), [], []
while len(turns) < 20:
    frame, message = bus.recv(10), PiperMessage()
    assert parser.DecodeMessage(frame, message), frame
    joints = message.arm_joint_feedback
    if message.type_ == ArmMsgType.PiperMsgJointFeedBack_12:
        turn = [joints.joint_1, joints.joint_2]
    elif message.type_ == ArmMsgType.PiperMsgJointFeedBack_34:
        turn += [joints.joint_3, joints.joint_4]
    elif message.type_ == ArmMsgType.PiperMsgJointFeedBack_56:
        turn += [joints.joint_5, joints.joint_6]
        turns += [turn] * (len(turn) == 6)
bus.shutdown()
print(json.dumps(turns))
"""

SERVOS = """
import json, sys, {module} as sdk
sdk.port_handler.LATENCY_TIMER = 5000  # [ms]: a loaded machine is no failure
port, packets, joints = sdk.PortHandler(sys.argv[1]), sdk.PacketHandler({protocol}), {joints}
assert port.openPort() and port.setBaudRate(1000000)
models = {{packets.ping(port, servo)[:2] for servo in range(1, joints[-1] + 2)}}
assert models == {{({model}, 0)}}, models
together = sdk.GroupSyncRead(port, packets, {register}, {size})
assert all(together.addParam(servo) for servo in joints)
states = []
for _ in range(50):
    assert together.txRxPacket() == 0
    states.append([together.getData(servo, {register}, {size}) for servo in joints])
one, *ends = packets.read{size}ByteTxRx(port, joints[2], {register})
assert ends == [0, 0] and packets.read1ByteTxRx(port, joints[2], {torque}) == (0, 0, 0)
print(json.dumps([states, one]))
"""
FEETECH = {"module": "scservo_sdk", "protocol": 0, "model": 777, "joints": (1, 2, 3, 4, 5)}
FEETECH |= {"register": 56, "size": 2, "torque": 40}
DYNAMIXEL = {"module": "dynamixel_sdk", "protocol": 2.0, "model": 1120}
DYNAMIXEL |= {"joints": (1, 2, 4, 6, 7, 8), "register": 132, "size": 4, "torque": 64}


def client(script, *arguments):
    """Run a client and return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments], capture_output=True, text=True, timeout=PATIENCE
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def need(module):
    if importlib.util.find_spec(module.partition(".")[0]) is None:
        pytest.skip(f"{module} has no wheel for this Python {sys.version_info[:2]}")


def as_float32(values):
    return list(struct.unpack(f"<{len(values)}f", struct.pack(f"<{len(values)}f", *values)))


@pytest.mark.parametrize(
    ("module", "version", "width"),
    [("panda_py.libfranka", "5", list), ("pylibfranka", "10", as_float32)],
)
def test_libfranka_reads_what_the_emulator_sent(module, version, width, tmp_path):
    need(module)
    with emulated_program("franka", tmp_path, "--version", version) as emulation:
        states = client(LIBFRANKA.format(module=module), emulation.host)
        emulation.stop()
        sent = emulation.sent()
    assert len({state["number"] for state in states}) == 200
    for state in states:
        truth = sent[state["number"]]
        assert state["q"] == width(truth["position"])
        assert state["tau_J"] == width(truth["effort"])
        assert state["mode"].endswith("Guiding")


@pytest.mark.parametrize(("version", "frequency"), [("5.11", 500), ("3.15", 125), ("10.7", 500)])
def test_ur_rtde_reads_what_the_emulator_sent_and_asks_for_it_as_we_do(
    version, frequency, tmp_path
):
    """Byte by byte but for the names of the outputs, and the comma that ur-rtde adds after them."""
    need("rtde_receive")
    with emulated_program("ur", tmp_path, "--version", version) as emulation:
        states = client(UR_RTDE.format(frequency=frequency), emulation.host)
        theirs = b"".join(message for _, message in emulation.received())
        with open_driver("ur", emulation.address) as driver:
            driver.read(PATIENCE)
        emulation.stop()
        sent = emulation.sent()
        ours = b"".join(message for _, message in emulation.received())[len(theirs) :]
    for stamp, q, torque in states:
        truth = sent[round(stamp * frequency)]
        assert q == truth["position"]
        assert torque == truth["effort"]
    names = b"timestamp,actual_q,target_moment,"
    own_names = b"timestamp,actual_q,robot_mode,safety_mode"
    setup = theirs.index(names) - 11
    size = int.from_bytes(theirs[setup : setup + 2], "big") + len(own_names) - len(names)
    expected = theirs[:setup] + size.to_bytes(2, "big") + theirs[setup + 2 :]
    assert ours == expected.replace(names, own_names)


def test_piper_sdk_parses_what_the_emulator_sent(tmp_path):
    need("piper_sdk")
    with emulated_program("piper", tmp_path) as emulation:
        port = emulation.address.partition("port=")[2].partition("&")[0]
        turns = client(PIPER, port)
        emulation.stop()
        sent = [
            [round(angle * 180_000 / 3.141592653589793) for angle in state["position"]]
            for state in emulation.sent().values()
        ]
    assert all(turn in sent for turn in turns)


@pytest.mark.parametrize(("name", "words"), [("feetech", FEETECH), ("dynamixel", DYNAMIXEL)])
def test_the_servos_makers_read_what_the_emulator_sent_and_ask_as_we_do(name, words, tmp_path):
    need(words["module"])
    with emulated_program(name, tmp_path) as emulation:
        states, one = client(SERVOS.format(**words), emulation.address.partition("?")[0])
        theirs = {message for _, message in emulation.received()}
        with open_driver(name, emulation.address) as driver:
            driver.read(PATIENCE)
        emulation.stop()
        ours = [message for _, message in emulation.received()]
        sent = [
            [round(2048 + q * 2048 / math.pi) for q in state["position"]]
            for state in emulation.sent().values()
        ]
    assert states == sent[:50] and one == sent[50][2]
    assert ours[-1] in theirs


FLAGGED_EMULATOR = """
import sys
from mukca.tools.cli import main
from mukca.tools.emulators import udp_arms
plain = udp_arms.encode_state
def flagged(version, number, state):
    datagram = bytearray(plain(version, number, state))
    count = 37 if version < 5 else 41
    datagram[-2 * count - (5 if version == 10 else 9) + number % count] = 1
    return bytes(datagram)
udp_arms.encode_state = flagged
sys.exit(main(sys.argv[1:]))
"""

LIBFRANKA_ERRORS = """
import json, sys
import {module} as library
robot = library.Robot(sys.argv[1], library.RealtimeConfig.kIgnore)
names = [name for name in dir(library.Errors) if not name.startswith("_")]
found = {{}}
while len(found) < 41:
    state = robot.read_once()
    errors = [name for name in names if getattr(state.current_errors, name)]
    found[round(state.time.to_sec() * 1000) % 41] = errors
print(json.dumps(found))
"""


@pytest.mark.parametrize(
    ("module", "version"), [("panda_py.libfranka", "5"), ("pylibfranka", "10")]
)
def test_our_names_of_errors_are_libfrankas(module, version, tmp_path):
    need(module)
    command = (sys.executable, "-c", FLAGGED_EMULATOR)
    with emulated_program("franka", tmp_path, "--version", version, command=command) as emulation:
        found = client(LIBFRANKA_ERRORS.format(module=module), emulation.host)
        ours = {}
        with open_driver("franka", emulation.address) as driver:
            while len(ours) < 41:
                number = round(driver.read(PATIENCE).stamp * 1000) % 41
                ours[number] = driver.status.removeprefix("guiding; ").replace(" ", "_")
    for index, names in found.items():
        if names:  # panda_py shows the first 37 of them
            assert names == [ours[int(index)]]
    assert sum(map(bool, found.values())) in (37, 41)


@pytest.mark.parametrize(
    ("port", "version"), [(30000, "xarm6"), (30002, "xarm6"), (30003, "xarm6-old")]
)
def test_the_structures_of_xarm_s_maker_read_what_the_emulator_sent(port, version, tmp_path):
    need("xarm")
    from xarm.x3.report import ReportDataStructure

    options = ("--version", version, "--noise", "0")
    with emulated_program("xarm", tmp_path, *options) as emulation:
        with socket.create_connection((emulation.host, port)) as controller:
            size = controller.recv(4, socket.MSG_WAITALL)
            rest = controller.recv(int.from_bytes(size, "big") - 4, socket.MSG_WAITALL)
        with open_driver("xarm", emulation.address) as driver:  # the arm still rests
            driver.read(PATIENCE)
        emulation.stop()
        truth = emulation.sent()[1]
    theirs = ReportDataStructure.create(port)
    theirs.update(size + rest)
    assert theirs.data_size == 4 + len(rest)
    assert theirs.actual_joint_angle == pytest.approx([*truth["position"], 0.0])
    assert theirs.estimated_joint_torque == pytest.approx([*truth["effort"], 0.0], abs=0.2)
    assert (theirs.mode, theirs.state) == (2, 2)
    if port == 30000:
        assert theirs.timestamp == 5_004_000
    if port == 30002:
        assert theirs.robot_axis == 6
