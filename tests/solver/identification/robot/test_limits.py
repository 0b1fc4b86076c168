"""Joints at their limits."""

import pytest

from mukca.solver.identification.robot import choose_parameters, load_robot
from mukca.solver.results import CalibratedRobot


@pytest.fixture(scope="module")
def arm():
    panda = load_robot("panda")
    return CalibratedRobot(panda, choose_parameters(panda))


@pytest.mark.parametrize("joint", range(7))
def test_a_joint_that_stands_at_either_limit_is_named(arm, joint):
    for limits, inwards in ((arm.robot.lower, 1.0), (arm.robot.upper, -1.0)):
        q = arm.middle
        q[joint] = limits[joint]
        assert arm.stopped(q) == arm.robot.joint_names[joint]
        q[joint] += 0.1 * inwards
        assert arm.stopped(q) == ""
