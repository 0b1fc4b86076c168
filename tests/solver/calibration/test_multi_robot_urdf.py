"""One URDF of several arms: chains of one file stay in it, each second base where it stands."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from mukca.solver.calibration.multi_robot_urdf import Placed, joined_urdf
from mukca.solver.identification.data import Pose
from mukca.solver.identification.robot import BallModel, ModelError, parse_robot, scan, turn
from mukca.solver.results import CalibratedRobot

HOME = Pose(np.eye(3), np.zeros(3))


def placed(name, robot, pose):
    return Placed(name, CalibratedRobot(robot, (), np.empty(0)), pose)


def ball(robot, q):
    return BallModel(robot, []).points(np.empty(0), q[None])[0]


TORSO = """<robot name="two"><link name="torso"/><link name="chest"/>
<joint name="spine" type="fixed"><origin xyz="0 0 0.5" rpy="0 0 0.3"/>
<parent link="torso"/><child link="chest"/></joint>{arms}</robot>"""
ARM = """<link name="{n}1"/><link name="{n}_ball"/>
<joint name="{n}_shoulder" type="revolute"><origin xyz="0 {y} 0" rpy="0 0.2 0"/><axis xyz="0 0 1"/>
<parent link="chest"/><child link="{n}1"/>
<limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="{n}_hand" type="fixed"><origin xyz="0.4 0 0"/>
<parent link="{n}1"/><child link="{n}_ball"/></joint>"""


def torso(spine="fixed"):
    arms = "".join(ARM.format(n=n, y=y) for n, y in (("l", 0.2), ("r", -0.2)))
    data = TORSO.format(arms=arms).replace('"spine" type="fixed"', f'"spine" type="{spine}"')
    return [parse_robot(scan(data.encode(), "t"), tip=f"{n}_ball") for n in "lr"]


def test_chains_of_one_file_stay_in_it():
    """What the second base is off goes into the first joint that is its own."""
    left, right = torso()
    off = Pose(turn(np.array([0.01, 0.02, -0.03])), np.array([0.01, -0.02, 0.005]))
    data = joined_urdf([placed("l", left, HOME), placed("r", right, off)])
    assert len(ET.fromstring(data).findall("link")) == 6
    q = np.array([0.4])
    for robot, pose in ((left, HOME), (right, off)):
        chain = parse_robot(scan(data, "t"), tip=robot.tip)
        assert ball(chain, q) == pytest.approx(pose.apply(ball(robot, q)[None])[0])


def test_a_joint_that_moves_both_chains_is_refused():
    left, right = torso("continuous")
    with pytest.raises(ModelError, match="joint 'spine' moves both l and r"):
        joined_urdf([placed("l", left, HOME), placed("r", right, HOME)])
