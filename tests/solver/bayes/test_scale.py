"""The size of an arm is that of its links, whatever is thought of the ball and the base."""

import numpy as np
import pytest

from mukca.solver.bayes.model import extend
from mukca.solver.design import expected_groups
from mukca.solver.robot import choose_parameters, load_robot

ROBOTS = ("panda", "ur5", "so101")


@pytest.mark.parametrize("name", ROBOTS)
def test_where_the_ball_was_guessed_to_be_says_nothing_of_it(name):
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    by_scale = extend(robot, parameters).by_scale()
    assert np.abs(by_scale[[p.of_ball for p in parameters]]).max() < 1e-9


@pytest.mark.parametrize("name", ROBOTS)
def test_all_links_longer_by_one_percent_are_one_percent(name):
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    model = extend(robot, parameters)
    links = [p.unit == "m" and not p.of_ball for p in parameters]
    assert model.by_scale() @ np.where(links, 0.01 * model.ball.nominal, 0) == pytest.approx(0.01)


def test_the_scale_is_free_where_lengths_are_not(panda):
    """However narrow the lengths' own prior has become, rounding leaves that of their scale."""
    model = extend(panda, choose_parameters(panda))
    group = next(g for g in expected_groups(model) if g.common is not None)
    t = group.common
    assert t is not None
    for width in (1e-3, 1e-6, 1e-9):
        known = float(t @ t)
        precision = t @ group.precision(width) @ t
        assert precision == pytest.approx(known / (width**2 + known), rel=1e-3)
