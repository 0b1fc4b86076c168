"""Known distances, in one placement and across."""

from dataclasses import replace

import pytest

from mukca.errors import MukcaError
from mukca.recorder import Placement, read_placement
from mukca.solver.data import (
    RobotRecordings,
    distance_covariance,
    measure,
    observe,
    parse_known,
)


def observed(measurements, robot, **options):
    return observe(RobotRecordings(robot, measurements), **options)


@pytest.fixture
def two(session, panda):
    return [measure(read_placement(session / name), panda) for name in ("front", "left")]


def test_known_distances_tie_placements(two, panda):
    known = parse_known("front:0-left:1=0.43+-0.0002")
    data = observed(two, panda, lengths=[known])
    assert (data.known[2].first, data.known[2].second) == (0, 3)
    assert (data.known[2].distance, data.known[2].deviation) == (0.43, 0.0002)
    assert parse_known("a-b:0-c:1=5e-2").deviation == 3e-5
    without = data.without([two[0].name])
    assert len(without.known) == 1 and without.socket_count == 2
    assert len(without.positions) == 24


def test_placements_of_one_base_share_the_error_of_its_measurement(two, panda):
    known = parse_known("front:0-left:1=0.43+-0.0002")
    covariance = distance_covariance(observed(two, panda, lengths=[known]).known)
    assert covariance[0, 1] == pytest.approx(3e-5**2)
    assert covariance[0, 0] == covariance[1, 1] == pytest.approx(3e-5**2 + 1e-5**2)
    assert covariance[2] == pytest.approx([0, 0, 2e-4**2])
    other = replace(two[1], distance=0.1)
    assert distance_covariance(observed([two[0], other], panda).known)[0, 1] == 0


@pytest.mark.parametrize("known", [0, 3])
def test_arrays_whose_joint_names_the_robot_lacks_are_refused(panda, known):
    names = [*panda.joint_names[:known], *(f"elbow{j}" for j in range(known, 7))]
    placement = Placement.of_arrays("a", [[0.1] * 7, [0.2] * 7], [0, 1], names)
    with pytest.raises(MukcaError, match=r"^a: .*panda_joint4"):
        measure(placement, panda)
