"""The size of an arm is that of its links, whatever is thought of the ball and the base."""

import numpy as np
import pytest

from mukca.solver.design import expected_groups
from mukca.solver.identification.effects import JOINT_OFFSET
from mukca.solver.identification.model import extend
from mukca.solver.identification.robot import (
    angles_near,
    choose_parameters,
    load_robot,
    rotation,
    rotation_rpy,
)
from mukca.tools.simulation import perturb

ROBOTS = ("panda", "ur5", "so101")


@pytest.mark.parametrize("name", ROBOTS)
def test_all_links_longer_by_one_percent_are_one_percent(name):
    """And where the ball was guessed to be says nothing of it."""
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    model = extend(robot, parameters)
    links = [p.unit == "m" and not p.of_ball for p in parameters]
    assert model.by_scale() @ np.where(links, 0.01 * model.ball.nominal, 0) == pytest.approx(0.01)
    assert np.abs(model.by_scale()[[p.of_ball for p in parameters]]).max() < 1e-9


def test_the_scale_is_free_where_lengths_are_not(panda):
    """However narrow the lengths' own prior has become, rounding leaves that of their scale."""
    model = extend(panda, choose_parameters(panda))
    group = next(g for g in expected_groups(model) if g.common is not None)
    t = group.common
    for width in (1e-3, 1e-6, 1e-9):
        known = float(t @ t)
        precision = t @ group.precision(width) @ t
        assert precision == pytest.approx(known / (width**2 + known), rel=1e-3)


@pytest.mark.parametrize("name", ROBOTS)
def test_zeros_make_no_link_longer(name):
    """Nor does an origin that is turned about its joint, which moves the balls as a zero does."""
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    model = extend(robot, parameters, [JOINT_OFFSET.name])
    by_scale = model.by_scale()
    assert np.abs(by_scale[len(parameters) :]).max() < 1e-9
    for i, joint in enumerate(robot.joints):
        if joint.actuated:
            turned = rotation_rpy(joint.origin.rpy) @ rotation(joint.axis, 1e-5)
            after = robot.origins
            after[i, 3:] = angles_near(np.array(turned.full()), after[i, 3:])
            changed = model.ball.parameters_at(after) - model.ball.nominal
            assert abs(by_scale[: len(parameters)] @ changed) < 1e-8


@pytest.mark.parametrize("zeros", [True, False])
def test_a_simulated_arm_has_its_size_as_a_fit_counts_it(zeros):
    robot = load_robot("so101")
    parameters = choose_parameters(robot)
    model = extend(robot, parameters, [JOINT_OFFSET.name] if zeros else [])
    arm = perturb(robot, np.random.default_rng(0), 2e-3, 5e-3, zeros=zeros)
    differences = model.ball.parameters_at(arm.origins) - model.ball.nominal
    assert abs(model.by_scale()[: len(parameters)] @ differences) < 1e-9
