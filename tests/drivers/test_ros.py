"""ROS: joints by name, and messages that are none."""

import json
import subprocess
import sys
from contextlib import contextmanager
from subprocess import PIPE, STDOUT

import pytest
from driver_errors import refused
from listeners import saying
from rosbridge import ARM, NAMES, arm_state, joint_state, rosbridge
from terminal_session import PATIENCE

from mukca import open_driver
from mukca.recorder.stream import JointLimits, StreamMonitor


@contextmanager
def reading(joints=ARM, options="", **settings):
    """A driver that reads a rosbridge."""
    with (
        rosbridge(**settings) as bridge,
        open_driver("ros", bridge.address + options, joints) as driver,
    ):
        yield driver


def first_state(message, joints=ARM, options=""):
    """Return what is read of a message, where the one before tells that the joints are there."""
    with reading(joints, options, first_messages=[message, message]) as driver:
        return driver.read(PATIENCE)


def test_joints_are_matched_by_name():
    state = first_state(joint_state(0))
    assert (state.position, state.effort) == ((0.1, 0.2, 0.3), (10.0, 20.0, 30.0))
    assert first_state(joint_state(0), ("arm_3", "arm_1"), "?effort=-1").effort == (-30.0, -10.0)


@pytest.mark.parametrize(
    "stamp", [{"secs": 3, "nsecs": 500_000_000}, {"sec": 3, "nanosec": 500_000_000}]
)
def test_stamps_of_ros_1_and_2(stamp):
    assert first_state(joint_state(0) | {"header": {"stamp": stamp}}).stamp == 3.5


@pytest.mark.parametrize(
    "effort", [[], None, [None] * 4, [0.0, 20.0, None, 30.0], [0.0, 20.0, float("nan"), 30.0]]
)
def test_efforts_may_lack(effort):
    """As ros2_control's joint_state_broadcaster has it for joints without a torque sensor."""
    state = first_state(joint_state(7) | {"effort": effort})
    assert (state.position, state.effort) == (arm_state(7)[0], None)
    elsewhere = [None, 20.0, 10.0, 30.0]  # at the gripper
    assert first_state(joint_state(7) | {"effort": elsewhere}).effort


def test_headers_without_a_stamp_are_told_and_arrival_times_taken():
    unstamped = [joint_state(n) | {"header": joint_state(0)["header"]} for n in range(100)]
    with reading(first_messages=unstamped) as driver:
        states = [driver.read(PATIENCE) for _ in range(99)]
        assert driver.status == "the headers have no stamps: times of arrival are taken"
    assert [state.position for state in states] == [arm_state(n)[0] for n in range(1, 100)]
    assert driver.rejected == 0


@pytest.mark.slow
def test_nothing_is_printed_of_a_message_that_is_none():
    """In a program of its own: pytest listens to the packages' loggers."""
    with rosbridge() as bridge:
        command = [sys.executable, "-m", "mukca", "stream", "--driver", f"ros:{bridge.address}"]
        words = [*command, "--json", "--seconds", str(PATIENCE)]
        with subprocess.Popen(words, stdout=PIPE, stderr=STDOUT, text=True) as program:
            said = [program.stdout.readline()]
            bridge.clients[0].send("garbage")
            bridge.clients[0].send(b"garbage")  # ends the connection
            while said[-1] and "is lost" not in said[-1]:
                said.append(program.stdout.readline())
            program.terminate()
    assert "is lost" in said[-1]
    assert not any("Traceback" in line for line in said)


def test_the_topic_is_a_setting_and_without_a_model_all_joints_are_read():
    topic = "/left/joint_states"
    with (
        rosbridge(topic=topic) as bridge,
        open_driver("ros", f"ws://{bridge.address}?topic={topic}") as driver,
    ):
        assert driver.joint_names == NAMES and driver.read(PATIENCE).position


ODD = [
    {"name": ["gripper"], "position": [0.5], "effort": [], "header": {"stamp": {}}},
    joint_state(0) | {"position": [1.0]},
    joint_state(0) | {"position": [1.0, None, 1.0, 1.0]},
    {},
]


def test_messages_of_others_and_odd_ones_are_counted():
    with reading(odd_messages=ODD) as driver:
        for _ in range(10):
            assert driver.read(PATIENCE).position == pytest.approx((0.1, 0.2, 0.3), abs=0.02)
        assert driver.rejected >= 9 * 3


def of_gripper(number):
    return joint_state(number) | {"name": ["finger"], "position": [0.5], "effort": []}


def test_messages_of_a_gripper_alone_do_not_count():
    fingers = [of_gripper(n) for n in range(200)]
    with reading(first_messages=fingers, others=lambda n: [of_gripper(n)]) as driver:
        states = [driver.read(PATIENCE) for _ in range(50)]
    assert [s.position for s in states] == [arm_state(n)[0] for n in range(1, 51)]
    assert (driver.rejected, driver.missed, driver.status) == (0, 0, "")
    with rosbridge(others=lambda n: [of_gripper(n)]) as bridge:
        assert open_driver("ros", bridge.address).joint_names == NAMES


def test_two_publishers_of_one_state_are_told():
    first = [joint_state(9)] * 2
    with reading(first_messages=first, others=lambda n: [joint_state(n + 5)]) as driver:
        for _ in range(60):
            driver.read(PATIENCE)
        assert "do two publishers send these joints?" in driver.status


def later(number, **values):
    state = joint_state(number)
    state["header"]["stamp"]["nanosec"] -= 2_000_000
    return state | values


@pytest.mark.parametrize("angles", [[9.0, 0.7, 0.1, 0.3], [0.0] * 4])
def test_two_publishers_of_other_states_are_told(angles):
    monitor = StreamMonitor([JointLimits(name) for name in ARM])
    with reading(others=lambda n: [later(n + 1, position=angles)]) as driver:
        for _ in range(60):
            state = driver.read(PATIENCE)
            monitor.feed(state, state.stamp)
    assert "two sources send these joints in turn; stop one" in monitor.trouble(state.stamp)


@pytest.mark.slow
@pytest.mark.waits
def test_a_joint_that_nobody_publishes_is_named():
    with rosbridge() as bridge, refused("WRONG_ROBOT") as caught:
        open_driver("ros", bridge.address, (*ARM, "arm_4"))
    assert "no joint arm_4" in str(caught.value)
    assert "gripper" in str(caught.value)


@pytest.mark.slow
@pytest.mark.waits
def test_a_topic_without_a_publisher_is_told():
    with rosbridge(topic="/other") as bridge, refused("UNREACHABLE", "nobody publishes"):
        open_driver("ros", bridge.address, ARM)


def test_a_connection_that_ends_is_told():
    with rosbridge() as bridge, open_driver("ros", bridge.address, ARM) as driver:
        driver.read(PATIENCE)
        bridge.clients[0].close()
        with refused("UNREACHABLE"):
            for _ in range(100):
                driver.read(1)


@pytest.mark.slow
@pytest.mark.waits
def test_what_is_no_rosbridge_is_told():
    text = json.dumps({"hello": 1}).encode()
    with saying(text, pause=0.01) as address, refused("PROTOCOL"):
        open_driver("ros", address)
