"""ROS: joints by name, and messages that are none."""

import json

import pytest
from listeners import saying
from rosbridge import ARM, NAMES, joint_state, rosbridge

from mukca.drivers import DriverError, Reason
from mukca.drivers.arms.ros import Ros, decode_message


def test_joints_are_matched_by_name():
    state = decode_message(joint_state(0), ARM, 1)
    assert state.position == (0.1, 0.2, 0.3)
    assert state.effort == (10.0, 20.0, 30.0)
    assert decode_message(joint_state(0), ("arm_3", "arm_1"), -1).effort == (-30.0, -10.0)


def test_stamps_of_ros_1_and_2():
    message = joint_state(0)
    message["header"]["stamp"] = {"secs": 3, "nsecs": 500_000_000}
    assert decode_message(message, ARM, 1).stamp == 3.5
    message["header"]["stamp"] = {"sec": 4, "nanosec": 250_000_000}
    assert decode_message(message, ARM, 1).stamp == 4.25


def test_efforts_may_lack():
    message = joint_state(0) | {"effort": []}
    assert decode_message(message, ARM, 1).effort is None


def test_without_a_model_all_joints_are_read():
    with rosbridge() as bridge, Ros(bridge.address) as driver:
        assert driver.joint_names == NAMES


def test_the_topic_is_a_setting():
    topic = "/left/joint_states"
    with rosbridge(topic=topic) as bridge, Ros(f"ws://{bridge.address}?topic={topic}") as driver:
        assert driver.read(5).position


ODD = [
    {"name": ["gripper"], "position": [0.5], "effort": [], "header": {"stamp": {}}},
    joint_state(0) | {"position": [1.0]},
    joint_state(0) | {"position": [1.0, None, 1.0, 1.0]},
    {},
]


def test_messages_of_others_and_odd_ones_are_counted():
    with rosbridge(odd_messages=ODD) as bridge, Ros(bridge.address, ARM) as driver:
        for _ in range(10):
            assert driver.read(5).position == pytest.approx((0.1, 0.2, 0.3), abs=0.02)
        assert driver.rejected >= 9 * len(ODD)


def test_a_joint_that_nobody_publishes_is_named(monkeypatch):
    monkeypatch.setattr("mukca.drivers.arms.ros.FIRST_STATE_SECONDS", 1.0)
    with rosbridge() as bridge, pytest.raises(DriverError) as caught:
        Ros(bridge.address, (*ARM, "arm_4"))
    assert caught.value.reason is Reason.WRONG_ROBOT
    assert "no joint arm_4" in str(caught.value)
    assert "gripper" in str(caught.value)


def test_a_topic_without_a_publisher_is_told(monkeypatch):
    monkeypatch.setattr("mukca.drivers.arms.ros.FIRST_STATE_SECONDS", 1.0)
    with rosbridge(topic="/other") as bridge, pytest.raises(DriverError) as caught:
        Ros(bridge.address, ARM)
    assert caught.value.reason is Reason.UNREACHABLE
    assert "nobody publishes" in str(caught.value)


def test_a_connection_that_ends_is_told():
    with rosbridge() as bridge, Ros(bridge.address, ARM) as driver:
        driver.read(5)
        bridge.clients[0].close()
        with pytest.raises(DriverError) as caught:
            for _ in range(100):
                driver.read(1)
    assert caught.value.reason is Reason.UNREACHABLE


def test_what_is_no_rosbridge_is_told(monkeypatch):
    monkeypatch.setattr("mukca.drivers.arms.ros.CONNECT_SECONDS", 1.0)
    text = json.dumps({"hello": 1}).encode()
    with saying(text, pause=0.01) as address, pytest.raises(DriverError) as caught:
        Ros(address)
    assert caught.value.reason is Reason.PROTOCOL
