"""Decoders against bytes that nobody should send: a ValueError, or what was really meant.

Three kinds of bytes: any at all; good messages with some bytes changed; good messages with one
thing wrong that must be noticed. benchmarks/hostile.py does the same a million times.
"""

import math
import struct
import zlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mukca.drivers import JointState
from mukca.drivers.arms.franka_state import LAYOUTS, decode_state
from mukca.drivers.arms.fri import decode_message
from mukca.drivers.arms.kinova.actuator_messages import decode_reply
from mukca.drivers.arms.piper import decode_frame
from mukca.drivers.arms.ros import decode_message as decode_ros
from mukca.drivers.arms.rtde import Recipe, decode_recipe, take_package
from mukca.drivers.arms.servos import dynamixel, feetech
from mukca.tools.emulators.franka import encode_state
from mukca.tools.emulators.kuka import encode_message


def hostile(test):
    """Run a test on 300 examples."""
    return pytest.mark.slow(settings(max_examples=300, deadline=None)(test))


Q = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6, 0.7)
STATE = JointState(0.0, Q, Q)
FRANKA = {version: encode_state(version, 5, STATE) for version in (3, 4, 9, 10)}
FRI = {
    version: encode_message(version, (0x245142, 7, 6), (2, 3, 5, 1), STATE, 123_456_789)
    for version in ("1.15", "2.5", "2.7")
}
RTDE = struct.pack(">Bd6dii", 1, 2.5, *Q[:6], 7, 1)
KINOVA = struct.pack("<hBB4f", 2, 0x12, 0, 0.5, 90.0, 0.0, 3.0)


def changed(message, changes):
    """Return a message with bytes at some places replaced."""
    copy = bytearray(message)
    for place, byte in changes:
        copy[place % len(copy)] = byte
    return bytes(copy)


changes = st.lists(st.tuples(st.integers(0, 4096), st.integers(0, 255)), max_size=6)


def assert_plausible(angles, largest):
    assert all(math.isfinite(angle) and abs(angle) <= largest for angle in angles)


def rejected(decode, *arguments):
    with pytest.raises(ValueError):
        decode(*arguments)


@hostile
@given(st.binary(max_size=64), st.sampled_from([*LAYOUTS, 12, 500]))
def test_franka_takes_no_stray_datagram(noise, length):
    noise = b"\xff" + (noise * (length // max(1, len(noise)) + 1))[: length - 1]
    try:
        state = decode_state(noise)
    except ValueError:
        return
    assert len(noise) in LAYOUTS
    assert_plausible(state.position, 2 * math.pi)


@hostile
@given(st.sampled_from(sorted(FRANKA)), changes, st.integers(-20, 20))
def test_franka_changed(version, places, longer):
    message = changed(FRANKA[version], places)
    message = message[:longer] if longer < 0 else message + bytes(longer)
    try:
        state = decode_state(message)
    except ValueError:
        return
    assert longer == 0
    assert_plausible(state.position, 2 * math.pi)
    assert all(map(math.isfinite, state.torque))


@pytest.mark.parametrize("version", FRANKA)
@pytest.mark.parametrize("value", [math.nan, math.inf, 1e300, 7.0])
def test_franka_impossible_angles(version, value):
    q = list(Q)
    q[3] = value if version != 10 or value < 1e38 or not math.isfinite(value) else 1e38
    rejected(decode_state, encode_state(version, 5, JointState(0.0, tuple(q), Q)))


@pytest.mark.parametrize("version", FRANKA)
def test_franka_impossible_flags_and_modes(version):
    tail = 5 if version == 10 else 9
    for place in (-tail, -tail - 1, -tail - 70):  # robot mode, last and an early error flag
        rejected(decode_state, changed(FRANKA[version], [(place, 7)]))


@hostile
@given(st.binary(max_size=300))
def test_fri_takes_no_stray_datagram(noise):
    rejected(decode_message, noise)


@hostile
@given(st.sampled_from(sorted(FRI)), changes, st.integers(0, 400))
def test_fri_changed_or_cut(version, places, kept):
    message = changed(FRI[version], places)[: kept or None]
    try:
        decoded = decode_message(message)
    except ValueError:
        return
    assert_plausible(decoded.position, 2 * math.pi)
    assert len(decoded.position) in (0, 7)
    if version == "2.7":
        assert message == FRI[version], "a wrong checksum was taken"
    elif not places:
        assert decoded.position == Q


@pytest.mark.parametrize("version", FRI)
def test_fri_one_thing_wrong(version):
    def message(header=(0x245142, 7, 6), connection=(2, 3, 5, 1), state=STATE):
        return encode_message(version, header, connection, state, 0)

    assert decode_message(message()).position == Q
    rejected(decode_message, message(header=(0x34001, 7, 6)))  # a command
    rejected(decode_message, message(connection=(5, 3, 5, 1)))  # no such session state
    rejected(decode_message, message(connection=(2, 9, 5, 1)))  # no such quality
    rejected(decode_message, message(state=JointState(0, (*Q[:6], math.nan), Q)))
    rejected(decode_message, message(state=JointState(0, (*Q[:6], 100.0), Q)))
    rejected(decode_message, message(state=JointState(0, Q, (*Q, 1.0))))  # a torque too many
    for wrong in (math.nan, math.inf):  # no limit of joint angles notices these
        rejected(decode_message, message(state=JointState(0, Q, (*Q[:6], wrong))))


def test_fri_27_is_known_by_its_frame():
    framed, body = FRI["2.7"], FRI["2.7"][4:-4]
    assert decode_message(framed).framed
    assert not decode_message(body).framed
    wrong = struct.pack("<I", len(body)) + body + struct.pack("<I", zlib.crc32(body) ^ 1)
    rejected(decode_message, wrong)


@hostile
@given(st.binary(max_size=200))
def test_rtde_takes_no_stray_bytes(noise):
    stream = bytearray(noise)
    try:
        while (package := take_package(stream)) is not None:
            state = Recipe(1, effort=False).decode(package[1])
            assert_plausible(state.position, 4 * math.pi)
    except ValueError:
        return


@hostile
@given(changes, st.integers(-4, 4))
def test_rtde_changed(places, longer):
    message = changed(RTDE, places)
    message = message[:longer] if longer < 0 else message + bytes(longer)
    try:
        state = Recipe(1, effort=False).decode(message)
    except ValueError:
        return
    assert longer == 0
    assert message[0] == 1
    assert_plausible(state.position[:5], 4 * math.pi)
    assert math.isfinite(state.position[5])  # wrist 3 of a UR3 turns without end
    assert math.isfinite(state.timestamp)


@hostile
@given(st.binary(max_size=80))
def test_rtde_recipes(noise):
    rejected(decode_recipe, noise, None)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", range(7))
def test_rtde_numbers_that_are_none(place, value):
    numbers = [2.5, *Q[:6]]
    numbers[place] = value
    rejected(Recipe(1, effort=False).decode, struct.pack(">Bd6dii", 1, *numbers, 7, 1))


def test_rtde_recipe_with_an_output_that_is_not_there():
    good = b"\x01DOUBLE,VECTOR6D,INT32,INT32"
    assert decode_recipe(good, None) == Recipe(1, effort=False)
    with pytest.raises(ValueError, match="no output called actual_torque"):
        decode_recipe(good + b",NOT_FOUND", "actual_torque")


@hostile
@given(st.one_of(st.binary(max_size=40), st.binary(min_size=20, max_size=20)))
def test_kinova_takes_no_stray_message(noise):
    if noise[:4] != KINOVA[:4]:
        rejected(decode_reply, noise, 0x12)


@hostile
@given(changes)
def test_kinova_changed(places):
    message = changed(KINOVA, places)
    try:
        reply = decode_reply(message, 0x12)
    except ValueError:
        return
    assert message[:4] == KINOVA[:4]
    assert math.isfinite(reply.torque)
    assert abs(reply.degrees) <= 36_000


@hostile
@given(st.binary(max_size=16))
def test_piper_takes_no_stray_frame(data):
    try:
        assert_plausible(decode_frame(data), 2 * math.pi)
    except ValueError:
        return
    assert len(data) == 8


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
        state = decode_ros(message, ("b", "a"), 1)
    except ValueError:
        return
    assert len(state.position) == 2
    assert all(map(math.isfinite, (*state.position, *(state.effort or ()), state.stamp)))


STS = bytes.fromhex("ffff0104000008f2")
X = bytes.fromhex("fffffd000108005500000800001c38")


@pytest.mark.slow
@settings(max_examples=200)
@given(st.sampled_from([(feetech, STS), (dynamixel, X)]), changes, st.integers(-4, 4))
def test_servos_changed(make_and_message, places, longer):
    make, good = make_and_message
    message = changed(good, places)
    message = message[:longer] if longer < 0 else message + bytes(longer)
    try:
        answer = make.decode_answer(message)
    except ValueError:
        return
    assert longer == 0
    if make is dynamixel:  # a CRC notices all that a few bytes can do; a sum does not
        assert message == good or len({place % len(good) for place, _ in places}) > 2
    assert answer.servo < 0xFE


@settings(max_examples=100)
@given(st.binary(max_size=60))
def test_servos_take_no_stray_bytes(noise):
    for make in (feetech, dynamixel):
        rejected(make.decode_answer, b"\x00" + noise)
