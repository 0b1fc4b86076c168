"""SDFormat: by the rules of its specification, joints, ball and tools are the calibrated arm's.

A pose stands relative to what ``relative_to`` names, a frame to what it is attached to, a link that
names nothing to the model; roll, pitch and yaw are URDF's.
"""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from imagined import configurations, edited, imagine, rigid

import mukca

TOOL = {"name": "pen", "parent": "", "xyz": [0.1, 0.0, 0.02], "rpy": [0.3, -0.2, 2.0]}
TOOL["covariance"] = [[0.0] * 3] * 3


def numbers(text):
    return np.array(text.split(), dtype=float)


def moved(axis, kind, q):
    """The motion of a joint about or along its axis."""
    T = np.eye(4)
    if kind == "prismatic":
        T[:3, 3] = axis * q
        return T
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    T[:3, :3] += np.sin(q) * K + (1 - np.cos(q)) * K @ K
    return T


class Model:
    """The frames of a model at joint positions by name."""

    def __init__(self, file):
        (model,) = ET.parse(file).getroot().iterfind("model")
        self.elements = {e.get("name"): e for e in model}
        assert len(self.elements) == len(model) and "world" not in self.elements
        self.above = {joint.findtext("child"): joint for joint in model.iterfind("joint")}

    def frame(self, name, q):
        """The pose of a link, joint or frame at zero, moved by the joints above it."""
        if name in ("__model__", "world"):
            return np.eye(4)
        element = self.elements[name]
        pose = element.find("pose")
        own = np.eye(4) if pose is None else rigid(numbers(pose.text))
        other = None if pose is None else pose.get("relative_to")
        if element.tag == "link" and name in self.above:
            joint = self.above[name]
            assert other == joint.get("name")
            if joint.get("type") != "fixed":
                axis = numbers(joint.findtext("axis/xyz"))
                own = moved(axis, joint.get("type"), q.get(other, 0.0)) @ own
        return self.frame(other or element.get("attached_to") or "__model__", q) @ own


def test_the_ball_is_the_calibrated_arms(export, imagined, tmp_path):
    file, calibration = imagined
    out = tmp_path / "model.sdf"
    status, shown, error = export(file, "--to", "sdformat", "--out", out)
    assert status == 0 and "mukca_ball" in shown, error
    model, robot = Model(out), calibration.robot
    for q in configurations(robot, 5):
        by_name = dict(zip(robot.joint_names, q, strict=True))
        to_base = np.linalg.inv(model.frame(robot.base, by_name))
        T = to_base @ model.frame("mukca_ball", by_name)
        ball = calibration.calibrated.geometric_ball(q[None])[0]
        assert np.abs(T[:3, 3] - ball).max() < 1e-9


URDF = """<robot name="cart">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="world"/>
  <joint name="rail" type="prismatic"><parent link="world"/><child link="rail"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><axis xyz="0 2 0"/>
    <limit lower="-1" upper="1" effort="9" velocity="3"/><dynamics damping="0.5"/></joint>
  <link name="rail"><inertial><origin xyz="0 0 0.1"/><mass value="2.5"/>
    <inertia ixx="1" ixy="0" ixz="0.1" iyy="1" iyz="0" izz="1"/></inertial>
    <visual><origin xyz="0 0 1"/><material name="red"/>
      <geometry><mesh filename="package://p/a.stl" scale="2 2 2"/></geometry></visual>
    <collision><geometry><cylinder radius="0.1" length="0.3"/></geometry></collision></link>
  <joint name="arm" type="continuous"><parent link="rail"/><child link="hand"/>
    <origin xyz="0 0.4 0"/><axis xyz="0.6 0 -0.8"/><limit effort="5" velocity="2"/></joint>
  <link name="hand"/>
  <joint name="finger" type="prismatic"><parent link="hand"/><child link="tip"/>
    <mimic joint="rail" multiplier="0.5"/>
    <limit lower="0" upper="1" effort="5" velocity="2"/></joint>
  <link name="tip"/>
  <joint name="ball" type="fixed"><parent link="hand"/><child link="ball_link"/>
    <origin xyz="0 0 0.1" rpy="0 0.5 0"/></joint><link name="ball_link"/>
  <gazebo/>
</robot>"""


@pytest.fixture
def cart(calibrations, tmp_path):
    """A calibration of a robot with all that a URDF may hold, and a tool."""
    (tmp_path / "cart.urdf").write_text(URDF)
    robot = mukca.load_robot(tmp_path / "cart.urdf")
    template = json.loads((calibrations / "fitted.json").read_text())
    file = tmp_path / "cart.json"
    file.write_text(json.dumps(imagine(robot, template)))
    return file


def test_shapes_masses_and_limits_are_the_urdfs(export, cart, tmp_path):
    out = tmp_path / "cart.sdf"
    status, shown, error = export(cart, "--to", "sdformat", "--out", out)
    assert status == 0, error
    assert "here 1 g: hand, tip, ball_link." in shown and "in <gazebo>" in shown
    model = Model(out)
    rail, joint = model.elements["rail"], model.elements["rail_joint"]
    assert float(rail.findtext("inertial/mass")) == 2.5
    assert float(rail.findtext("inertial/inertia/ixz")) == 0.1
    assert rail.findtext("inertial/pose").split()[2] == "0.1"
    assert rail.findtext("visual/geometry/mesh/uri") == "model://p/a.stl"
    assert rail.findtext("visual/material/diffuse") == "1 0 0 1"
    assert rail.findtext("collision/geometry/cylinder/length") == "0.3"
    limits = {e.tag: e.text for part in ("limit", "dynamics") for e in joint.find(f"axis/{part}")}
    assert limits == {"lower": "-1", "upper": "1", "effort": "9", "velocity": "3", "damping": "0.5"}
    assert joint.findtext("parent") == "world"
    mimic = model.elements["finger"].find("axis/mimic")
    assert mimic.get("joint") == "rail_joint" and mimic.findtext("multiplier") == "0.5"
    assert model.elements["hand"].findtext("inertial/mass") == "0.001"


def test_a_tool_that_was_found_is_a_frame(export, cart, tmp_path):
    tool = TOOL | {"parent": "hand"}
    edited(cart, cart, lambda document: document.update(tools=[tool]))
    out = tmp_path / "cart.sdf"
    assert export(cart, "--to", "sdformat", "--out", out)[0] == 0
    model = Model(out)
    T = np.linalg.inv(model.frame("hand", {})) @ model.frame("mukca_pen", {})
    assert np.abs(T - rigid((*TOOL["xyz"], *TOOL["rpy"]))).max() < 1e-12


def test_what_sdformat_cannot_say_is_refused(refused, cart, tmp_path):
    def floating(document):
        urdf = document["model"]["nominal_urdf"]
        document["model"]["nominal_urdf"] = urdf.replace(
            '"finger" type="prismatic"', '"finger" type="planar"'
        )

    edited(cart, cart, floating)
    words = ("export", cart, "--to", "sdformat", "--out")
    refused("joint 'finger' is planar", *words, tmp_path / "cart.sdf")
    refused("ends in .sdf", *words, tmp_path / "cart.xml")
