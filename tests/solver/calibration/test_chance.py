"""Two calibrations of one arm: how far apart, and how far by chance."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import RIGID

import mukca
from mukca.solver.calibration import Comparison, differences
from mukca.solver.identification.data import measure
from mukca.tools.simulation import perturb, reachable_bases, record

pytestmark = pytest.mark.slow
MOVED = 3e-3
"""Turn of a joint's zero between two recordings [rad]."""


@pytest.fixture(scope="module")
def sessions():
    """Four placements of one arm, and the last two after a joint's zero moved."""
    robot, generator = mukca.load_robot("ur5e"), np.random.default_rng(3)
    arm = perturb(robot, generator, 1e-3, 5e-3)
    bases = reachable_bases(arm, generator, 4)
    same = [record(arm, base, generator, samples=15, noise=1e-4) for base in bases]
    origins = arm.origins.copy()
    origins[3, 5] += MOVED
    moved = arm.with_origins(origins)
    later = [record(moved, base, generator, samples=15, noise=1e-4) for base in bases[2:]]
    return robot, same, [replace(one, name=f"later_{i}") for i, one in enumerate(later)]


def test_chance_explains_two_sessions_but_no_joint_that_moved(sessions):
    robot, same, later = sessions
    first, second, changed = (
        mukca.calibrate(robot, placements, **RIGID) for placements in (same[:2], same[2:], later)
    )
    data = [measure(one, robot) for one in same]
    workspace, places = differences(first, second, data)
    assert not any(apart.beyond_chance for apart in (workspace, *places))
    assert all(0.3 < apart.value / apart.chance < 3 for apart in (workspace, *places))
    workspace, places = differences(first, changed, data)
    assert all(apart.probability == 0 for apart in places)
    assert all(apart.value > 3 * apart.chance for apart in places)


def test_shared_samples_and_the_base_s_length_are_no_chance(sessions):
    robot, same, _ = sessions
    few, all_but_one = (
        mukca.calibrate(robot, placements, **RIGID) for placements in (same[:2], same[:3])
    )
    data = [measure(one, robot) for one in same[:1]]
    itself = Comparison(few.posterior, few.posterior, few.load).at(data[0])
    assert itself.value < 1e-12 and itself.chance < 0.35 * few.document.noise.space
    (more,), (none,) = (
        differences(few, other, data)[1]
        for other in (all_but_one, mukca.calibrate(robot, same[2:], distance=0.0501, **RIGID))
    )
    assert more.chance < 0.8 * none.chance and not more.beyond_chance


def test_chance_is_as_large_as_the_noise_for_arms_that_are_exactly_nominal():
    robot, generator = mukca.load_robot("ur5e"), np.random.default_rng(3)
    bases = reachable_bases(robot, generator, 2)
    first, second = (
        mukca.calibrate(robot, [record(robot, base, generator, samples=15, noise=1e-4)], **RIGID)
        for base in bases
    )
    fitted = first.posterior.groups
    assert any(group.width < 1e-6 for group in fitted if group.name in ("translation", "rotation"))
    workspace, _ = differences(first, second, [])
    assert 0.3 < workspace.value / workspace.chance < 3
    assert workspace.probability > 0.05


def test_the_paper_s_method_has_no_chance(sessions):
    robot, same, _ = sessions
    one = mukca.calibrate(robot, same[:1], method="paper")
    assert differences(one, one, [measure(same[0], robot)]) == (None, (None,))
