"""The mounting: a wrong direction of gravity is named with the option that says the right one."""

from dataclasses import replace

import numpy as np
import pytest
from cases import by_table
from recorded import recorded_in_reach, true_arm
from worlds import realistic_flaws

import mukca
from mukca.solver.diagnostics import Given, inspect_all
from mukca.solver.identification.data import STANDARD_LOAD, Load, measure


@pytest.mark.slow
@by_table("name", "gravity", "option")
def test_gravity_that_was_not_said_is_named(name, gravity, option):
    robot, generator = mukca.load_robot(name), np.random.default_rng([0, 5])
    arm = true_arm(robot, generator, 1e-3)
    how = replace(realistic_flaws(robot, generator), gravity=gravity)
    placements = recorded_in_reach(arm, generator, 2, 0.1, imperfection=how)
    data = [measure(placement, robot) for placement in placements]

    def told(load):
        found = inspect_all(robot, data, Given(load=load)).shared
        return " ".join(str(one) for one in found if one.code == "mounting")

    assert option in told(STANDARD_LOAD)
    assert bool(told(STANDARD_LOAD)) == bool(option)
    assert not told(Load(gravity, 0.0))
