"""Known distances, in one placement and across."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.errors import MukcaError
from mukca.recorder import Placement, read_placement
from mukca.solver.identification.data import (
    STANDARD_LOAD,
    RobotRecordings,
    Samples,
    distance_covariance,
    joined,
    measure,
    observe,
)
from mukca.solver.identification.robot import gravity_moments
from mukca.solver.tables import parse_known


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
    assert len(without.q) == len(without.moments) == 24


def test_each_row_is_one_sample_in_every_column(two, panda):
    """Whatever the order of recording: the rows are sorted by socket."""
    (first,) = two[:1]
    data = observed([first], panda)
    for row in ([5], np.arange(len(data.q)) == 17):
        one = data.only(row)
        (sample,) = (s for s in first.placement.samples if s.where == one.wheres[0])
        assert one.q.tolist() == [list(sample.position)] and one.sockets == [sample.socket]
        assert one.moments == pytest.approx(gravity_moments(panda, one.q))


def test_tables_one_below_the_other_have_the_rows_of_both(two, panda):
    tables = [STANDARD_LOAD.samples(panda, m) for m in two]
    both = joined(tables)
    for k, table in enumerate(tables):
        rows = both.only(slice(24 * k, 24 * k + 24))
        assert np.array_equal(rows.q, table.q) and np.array_equal(rows.moments, table.moments)


def test_a_clock_that_was_not_recorded_stands_still(two, panda):
    samples = STANDARD_LOAD.samples(panda, two[0])
    assert np.isnan(samples.clock("temperature")).all()
    order = samples.clock("index").ravel()
    assert not samples.temperature.any() and order.tolist() == two[0].order.tolist()
    assert not Samples.unloaded(samples.q).time.any()


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
