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
SCRIPT = ROS / "mukca_ros" / "true_joint_states.py"


class Node:
    def __init__(self, name):
        self.published = []
        self.warned = []

    def declare_parameter(self, name, default):
        assert name == "calibration"
        value = SimpleNamespace(string_value=os.environ["CALIBRATION"])
        return SimpleNamespace(get_parameter_value=lambda: value)

    def get_logger(self):
        return SimpleNamespace(warning=lambda text, **_: self.warned.append(text))

    def create_publisher(self, kind, topic, depth):
        assert topic == "joint_states_true"
        return SimpleNamespace(publish=self.published.append)

    def create_subscription(self, kind, topic, callback, depth):
        assert topic == "joint_states"


@pytest.fixture
def module(monkeypatch):
    for name in ("rclpy", "rclpy.node", "sensor_msgs", "sensor_msgs.msg"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    sys.modules["rclpy.node"].Node = Node  # type: ignore[attr-defined]
    sys.modules["sensor_msgs.msg"].JointState = SimpleNamespace  # type: ignore[attr-defined]
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
    assert len(node.published) == 1 and node.warned
