"""The size of an arm is that of its links, whatever is thought of the ball and the base."""

import numpy as np
import pytest

from mukca.solver.auto.extended_model import extend
from mukca.solver.robot.parameters import choose_parameters
from mukca.solver.robot.urdf import load_robot

ROBOTS = ("panda", "ur5", "so101")


@pytest.mark.parametrize("name", ROBOTS)
def test_where_the_ball_was_guessed_to_be_says_nothing_of_it(name: str) -> None:
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    by_scale = extend(robot, parameters).by_scale()
    assert np.abs(by_scale[[p.of_ball for p in parameters]]).max() < 1e-9


@pytest.mark.parametrize("name", ROBOTS)
def test_all_links_longer_by_one_percent_are_one_percent(name: str) -> None:
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    model = extend(robot, parameters)
    links = [p.unit == "m" and not p.of_ball for p in parameters]
    assert model.by_scale() @ np.where(links, 0.01 * model.ball.nominal, 0) == pytest.approx(0.01)
