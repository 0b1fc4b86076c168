"""The node for ROS 2 in packaging/, with a stand-in for rclpy."""

import os
import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import mukca

ROS = Path(__file__).parents[3] / "packaging" / "ros2" / "mukca_ros"
STORED = Path(__file__).parents[2] / "stored" / "1.0" / "calibrated"
SCRIPT = ROS / "mukca_ros" / "true_joint_states.py"


class Branches(SimpleNamespace):
    """A message whose parts are made when they are first named."""

    def __getattr__(self, name):
        part = Branches()
        setattr(self, name, part)
        return part


class Node:
    def __init__(self, name):
        self.published = []
        self.placed = []
        self.warned = []

    def declare_parameter(self, name, default):
        assert name in ("calibration", "relative_to", "tool")
        value = SimpleNamespace(string_value=os.environ.get(name.upper(), default))
        return SimpleNamespace(get_parameter_value=lambda: value)

    def get_logger(self):
        return SimpleNamespace(warning=lambda text, **_: self.warned.append(text))

    def create_publisher(self, kind, topic, depth):
        assert topic in ("joint_states_true", "flange_pose")
        into = self.published if topic == "joint_states_true" else self.placed
        return SimpleNamespace(publish=into.append)

    def create_subscription(self, kind, topic, callback, depth):
        assert topic == "joint_states"


@pytest.fixture
def module(monkeypatch):
    messages = ("sensor_msgs", "sensor_msgs.msg", "geometry_msgs", "geometry_msgs.msg")
    for name in ("rclpy", "rclpy.node", *messages):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["rclpy.node"].Node = Node  # type: ignore[attr-defined]
    sys.modules["sensor_msgs.msg"].JointState = SimpleNamespace  # type: ignore[attr-defined]
    sys.modules["geometry_msgs.msg"].PoseWithCovarianceStamped = Branches  # type: ignore[attr-defined]
    return runpy.run_path(str(SCRIPT))


@pytest.mark.slow
def test_it_corrects_the_arms_joints_and_leaves_the_others(module, calibrations, monkeypatch):
    file = calibrations / "panda.json"
    monkeypatch.setenv("CALIBRATION", str(file))
    node = module["TrueJointStates"]()
    arm = mukca.load_calibration(file)
    names = [*arm.robot.joint_names[::-1], "finger"]
    position = np.linspace(-1, 1, 8).tolist()
    read = np.array(position[6::-1])
    message = SimpleNamespace(name=names, position=list(position))
    node.correct(message)
    node.correct(SimpleNamespace(name=["finger"], position=[0.02]))
    node.correct(SimpleNamespace(name=names, position=[], velocity=[0.0] * 8))
    (published,) = node.published
    assert published.position[7] == position[7]
    assert np.array_equal(published.position[6::-1], arm.virtual_positions(read))
    assert published.position != position
    node.correct(SimpleNamespace(name=names, position=[np.nan] * 8))
    assert len(node.published) == 1 and node.warned and not node.placed


def test_it_says_how_well_the_flange_is_known(module, monkeypatch):
    file = STORED / "calibration.json"
    monkeypatch.setenv("CALIBRATION", str(file))
    node, arm = module["TrueJointStates"](), mukca.load_calibration(file)
    read = arm.calibrated.middle.tolist()
    header = SimpleNamespace(stamp=7)
    names = list(arm.robot.joint_names)
    node.correct(SimpleNamespace(name=names, position=list(read), header=header))
    (pose,) = node.placed
    assert (pose.header.frame_id, pose.header.stamp) == (arm.robot.base, 7)
    place = pose.pose.pose.position
    assert [place.x, place.y, place.z] == arm.flange(read)[:3, 3].tolist()
    assert pose.pose.covariance == arm.deviation(read).ravel().tolist()


@pytest.mark.parametrize("tool", ["", "ball_link"])
def test_with_a_start_it_says_how_well_the_movement_is_known(module, monkeypatch, tool):
    file = STORED / "calibration.json"
    arm = mukca.load_calibration(file)
    read = arm.calibrated.middle
    start = (read + 0.1).tolist()
    monkeypatch.setenv("CALIBRATION", str(file))
    monkeypatch.setenv("RELATIVE_TO", ",".join(map(str, start)))
    monkeypatch.setenv("TOOL", tool)
    node = module["TrueJointStates"]()
    pose = node.pose(read.tolist(), 7)
    expected = arm.deviation(read, relative_to=start, tool=tool or None)
    assert pose.pose.pose.position.x == arm.flange(read, tool=tool or None)[0, 3]
    assert pose.pose.covariance == expected.ravel().tolist()
    assert np.trace(expected[:3, :3]) < 0.1 * np.trace(arm.deviation(read)[:3, :3])
