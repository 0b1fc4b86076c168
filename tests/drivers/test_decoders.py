"""Decoders: worked examples of their bytes, and bytes that nobody should send.

The latter are of three kinds: any at all; good messages with some bytes changed; good messages with
one thing wrong that must be noticed.
"""

import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mukca.drivers import JointState
from mukca.drivers.arms import damiao, franka, fri, piper, ros, ur, xarm
from mukca.drivers.arms.fri import nested, numbers, varint
from mukca.drivers.arms.kinova_bus import decode_reply
from mukca.drivers.arms.servos import dynamixel, feetech
from mukca.drivers.arms.servos.servo_arm import Answer
from mukca.tools.emulators.tcp_arms import fast_report, real_report, rich_report
from mukca.tools.emulators.udp_arms import encode_message, encode_state

Q = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7)
STATE, SIX = JointState(0.0, Q, Q), JointState(0.0, Q[:6], Q[:6])
RECIPE = ur.Recipe(1, effort=False)
FRANKA = {version: encode_state(version, 5, STATE) for version in (3, 4, 9, 10)}
FRI = {
    version: encode_message(version, (0x245142, 7, 6), (2, 3, 5, 1), STATE, 123_456_789)
    for version in ("1.15", "2.5", "2.7")
}


def franka_angles(message):
    state, _ = franka.decode_state(message)
    assert all(map(math.isfinite, state.effort))
    return state.position


def rtde_angles(message):
    state, _ = RECIPE.decode(message)
    assert math.isfinite(state.stamp) and math.isfinite(state.position[5])
    return state.position[:5]  # wrist 3 of a UR3 turns without end


def xarm_angles(layout):
    return lambda message: xarm.decode_report(message, layout).angles


DECODERS = {
    **{f"franka {v}": (franka_angles, message, 2 * math.pi) for v, message in FRANKA.items()},
    **{
        f"fri {v}": (lambda message: fri.decode_message(message).position, message, 2 * math.pi)
        for v, message in FRI.items()
    },
    "rtde": (rtde_angles, struct.pack(">Bd6dii", 1, 2.5, *Q[:6], 7, 1), 4 * math.pi),
    "kinova": (
        lambda message: [decode_reply(message, 0x12)[0]],
        struct.pack("<hBB4f", 2, 0x12, 0, 0.5, 90.0, 0.0, 3.0),
        36_000,
    ),
    "piper": (piper.decode_frame, struct.pack(">ii", 90_000, -1), 2 * math.pi),
    "damiao": (
        lambda message: [damiao.decode_feedback(message, 1)[0]],
        bytes.fromhex("01851e7ff825191b"),
        12.5,
    ),
    "xarm 30000": (xarm_angles(xarm.FAST), fast_report(5_000_000, SIX), 6.4),
    "xarm 30002": (lambda message: [xarm.decode_arm(message)[0]], rich_report(SIX), 7),
    "xarm 30003": (xarm_angles(xarm.REAL), real_report(SIX), 6.4),
    "feetech": (
        lambda message: [feetech.decode_answer(message).servo],
        bytes.fromhex("ffff0104000008f2"),
        0xFD,
    ),
    "dynamixel": (
        lambda message: [dynamixel.decode_answer(message).servo],
        bytes.fromhex("fffffd000108005500000800001c38"),
        0xFC,
    ),
}


def hostile(test):
    """Run a test on 100 examples."""
    return pytest.mark.slow(settings(max_examples=100, deadline=None)(test))


def changed(message, changes):
    """Return a message with bytes at some places replaced."""
    copy = bytearray(message)
    for place, byte in changes:
        copy[place % len(copy)] = byte
    return bytes(copy)


def rejected(decode, *arguments):
    with pytest.raises(ValueError):
        decode(*arguments)


@pytest.mark.parametrize("name", DECODERS)
@hostile
@given(
    st.lists(st.tuples(st.integers(0, 4096), st.integers(0, 255)), max_size=6), st.integers(-20, 20)
)
def test_a_changed_message_is_refused_or_plausible(name, places, longer):
    decode, good, largest = DECODERS[name]
    message = changed(good, places)
    message = message[:longer] if longer < 0 else message + bytes(longer)
    try:
        angles = decode(message)
    except ValueError:
        return
    assert all(math.isfinite(angle) and abs(angle) <= largest for angle in angles)
    if not name.startswith(("fri 1.15", "fri 2.5", "xarm")):  # whose length is their fields'
        assert longer == 0
    if name == "fri 2.7":
        assert message == good, "a wrong checksum was taken"
    if name == "dynamixel":  # a CRC notices all that a few bytes can do
        assert message == good or len({place % len(good) for place, _ in places}) > 2


@pytest.mark.parametrize("name", DECODERS)
@hostile
@given(st.binary(max_size=300))
def test_stray_bytes_are_refused_or_plausible(name, noise):
    decode, good, largest = DECODERS[name]
    for message in (noise, (noise * (len(good) // max(1, len(noise)) + 1))[: len(good)]):
        try:
            angles = decode(message)
        except ValueError:
            continue
        assert all(math.isfinite(angle) and abs(angle) <= largest for angle in angles)


@pytest.mark.parametrize("version", FRANKA)
def test_franka_one_thing_wrong(version):
    tail = 5 if version == 10 else 9
    for place in (-tail, -tail - 1, -tail - 70):  # robot mode, last and an early error flag
        rejected(franka_angles, changed(FRANKA[version], [(place, 7)]))
    for wrong in (math.nan, math.inf, 1e38, 7.0):
        state = JointState(0.0, (*Q[:3], wrong, *Q[4:]), Q)
        rejected(franka_angles, encode_state(version, 5, state))


@pytest.mark.parametrize("version", [3, 5, 10])
def test_franka_mode_and_errors_in_words(version):
    datagram = bytearray(encode_state(version, 1, STATE))
    count, tail = (37 if version < 5 else 41), (5 if version == 10 else 9)
    datagram[-tail] = 4
    datagram[-tail - 2 * count + 6] = 1  # among the current errors
    datagram[-tail - count + 3] = 1  # among those of the last motion, which are not told
    assert franka.decode_state(bytes(datagram))[1] == "reflex; joint reflex"


@pytest.mark.parametrize("version", FRI)
def test_fri_one_thing_wrong(version):
    def message(header=(0x245142, 7, 6), connection=(2, 3, 5, 1), state=STATE):
        return encode_message(version, header, connection, state, 0)

    assert fri.decode_message(message()).position == Q
    for wrong in (
        message(header=(0x34001, 7, 6)),  # a command
        message(connection=(5, 3, 5, 1)),  # no such session state
        message(connection=(2, 9, 5, 1)),  # no such quality
        message(connection=(2, 3, 5, 2**40)),  # a reply that would never be due
        message(state=JointState(0, (*Q[:6], math.nan), Q)),
        message(state=JointState(0, (*Q[:6], 100.0), Q)),
        message(state=JointState(0, Q, (*Q, 1.0))),  # a torque too many
        message(state=JointState(0, Q, (*Q[:6], math.inf))),
    ):
        rejected(fri.decode_message, wrong)


def packed_message(stamp=b""):
    """A message of FRI 1.15 whose joint values are packed, with its stamp."""
    joints = nested(1, b"\x0a" + varint(56) + struct.pack("<7d", *Q))
    body = nested(1, numbers({1: 0x245142, 2: 7, 3: 0})) + nested(3, joints + stamp)
    return body + nested(4, numbers({1: 1, 2: 0, 3: 10}))


def test_fri_joint_values_may_be_packed():
    decoded = fri.decode_message(packed_message())
    assert (decoded.position, decoded.torque) == (Q, None)
    assert decoded.stamp == pytest.approx(0.07)  # seven periods of 10 ms


@pytest.mark.parametrize(("seconds", "nanoseconds"), [(0, 2**62), (0, 10**9), (2**62, 0)])
def test_fri_stamps_that_are_no_time(seconds, nanoseconds):
    rejected(fri.decode_message, packed_message(nested(15, numbers({1: seconds, 2: nanoseconds}))))


@hostile
@given(st.binary(max_size=200))
def test_streams_are_cut_into_messages_or_refused(noise):
    for take in (ur.take_package, xarm.take_report):
        stream = bytearray(noise)
        try:
            while take(stream) is not None:
                pass
        except ValueError:
            continue
        assert len(stream) < 4096
    rejected(ur.decode_recipe, noise, None)


def test_worked_examples():
    """Of other packages and their documents, or by hand."""
    angle, status = damiao.decode_feedback(bytes.fromhex("01851e7ff825191b"), 1)  # a DM8009
    assert (angle, status) == (pytest.approx(0.49992, abs=1e-5), 0)
    assert damiao.decode_query(bytes.fromhex("0100331500004841"), 1) == 12.5
    rejected(damiao.decode_feedback, bytes.fromhex("71851e7ff825191b"), 1)  # no such status
    reply = bytes.fromhex("0200 13 00 0000003f 0000b4c2 00000000 000040c0")
    assert decode_reply(reply, 0x13) == (-90.0, -3.0)
    angles = piper.decode_frame(struct.pack(">ii", 90_000, -1))
    assert angles == pytest.approx((math.pi / 2, -math.radians(0.001)))


leaves = st.sampled_from((None, True, 0, -1, 10**400, 0.5, 1e308, math.nan, math.inf, "", "a"))
json_values = leaves | st.lists(leaves, max_size=4) | st.dictionaries(st.just("a"), leaves)
stamps = st.fixed_dictionaries({"sec": json_values, "nanosec": json_values}) | json_values
messages = st.fixed_dictionaries(
    {
        "name": st.just(["a", "b"]) | json_values,
        "position": st.lists(st.floats(), max_size=3) | json_values,
        "header": st.fixed_dictionaries({"stamp": stamps}) | json_values,
    },
    optional={"effort": st.lists(st.floats(), max_size=3) | json_values},
)


@hostile
@given(messages | json_values)
def test_ros_takes_no_odd_message(message):
    try:
        state = ros.decode_message(message, ("b", "a"), 1)
    except ValueError:
        return
    assert len(state.position) == 2
    assert all(map(math.isfinite, (*state.position, *(state.effort or ()), state.stamp)))


STS, X = feetech.Feetech.make, dynamixel.Dynamixel.make
ANSWERS = [
    (STS, 2, "ffff0104000008f2", Answer(1, 0, b"\x00\x08")),
    (STS, 2, "ffff030400ff0fea", Answer(3, 0, b"\xff\x0f")),
    (X, 4, "fffffd000108005500000800001c38", Answer(1, 0, (2048).to_bytes(4, "little"))),
    (X, 4, "fffffd00040800550000fcffff622b", Answer(4, 0, b"\x00\xfc\xff\xff")),
    (X, 4, "fffffd000509005500fffffdfd008e1c", Answer(5, 0, b"\xff\xff\xfd\x00")),
]


@pytest.mark.parametrize(("make", "count", "text", "answer"), ANSWERS)
def test_a_servo_s_answer_is_found_among_other_bytes_whole_or_not_at_all(make, count, text, answer):
    """An echo of one's own request, noise, headers that are none, and a packet that is torn."""
    whole = bytes.fromhex(text)
    for noise in (make.encode_request(56, 2, (1, 2, 3)), b"\xff", b"\xff\xff", whole[:-1], b""):
        received = bytearray(noise + whole + whole)
        found = [make.take_answer(received, count) for _ in range(3)]
        assert [one for one in found if one] in ([answer, answer], [answer])
        assert answer in found[:2]
    for kept in range(len(whole)):
        assert make.take_answer(bytearray(whole[:kept]), count) is None
    for place in range(len(whole)):
        wrong = bytearray(whole)
        wrong[place] ^= 0x10
        assert make.take_answer(wrong, count) is None
