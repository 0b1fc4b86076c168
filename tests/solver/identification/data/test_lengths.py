"""Lengths are typed with or without their unit, and two readings that agree are believed."""

from dataclasses import replace

import numpy as np
import pytest
from project import ROOT

import mukca
from mukca.recorder import Placement
from mukca.solver.diagnostics import size_level
from mukca.solver.identification.data import agreed_length, measure, metres, millimetres
from mukca.solver.identification.robot import workspace


@pytest.mark.parametrize(
    "text", ["0.1001", "100.1mm", "100.1 mm", "10.01cm", "0.1001m", "1.001e-1"]
)
def test_a_length_means_the_same_in_every_unit(text):
    assert metres(text) == pytest.approx(0.1001)


def test_options_in_millimetres_take_other_units_too():
    assert [millimetres(text) for text in ("0.1", "0.1mm", "100um", "0.0001m")] == pytest.approx(
        [0.1] * 4
    )
    for text in ("mm", "0.1in", "1,5"):
        with pytest.raises(ValueError):
            millimetres(text)


def test_readings_may_be_an_array(panda):
    middle = np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    q = middle + np.random.default_rng(0).uniform(-0.3, 0.3, (8, 7))
    placement = Placement.of_arrays("a/b", q, [0, 1] * 4)
    measured = measure(placement, panda, np.array([0.05, 0.0501]))
    assert (measured.distance, measured.distance_readings) == (pytest.approx(0.05005), 2)


def test_a_joint_that_slides_is_asked_for_millimetres():
    robot = mukca.load_robot(ROOT / "tests/solver/identification/robot/crane.urdf")
    q = workspace(robot, 8)
    sockets = [0, 1] * 4
    measure(Placement.of_arrays("a/b", q, sockets), robot)
    in_millimetres = Placement.of_arrays("a/b", q * [1, 1000], sockets)
    with pytest.raises(mukca.MukcaError, match=r"lengths are metres \(are these millimetres\?"):
        measure(in_millimetres, robot)


def test_readings_that_agree_outvote_one_that_does_not():
    assert agreed_length([0.05]) == 0.05
    assert agreed_length([0.05, 0.0498, 0.04982]) == pytest.approx(0.04981)
    assert agreed_length([0.05, 0.0498]) == 0.0498  # the last one, where none agree


def test_a_reading_typed_again_agrees_with_that_of_the_recording(panda):
    middle = np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    q = middle + np.random.default_rng(0).uniform(-0.5, 0.5, (12, 7))
    names = panda.joint_names
    placement = Placement.of_arrays("a/b", q, [0, 1] * 6, joint_names=names, distance=0.05)
    counts = {}
    for given in (None, 0.05, (0.05, 0.05), 0.0499, 0.0496, (0.0496, 0.04965)):
        m = measure(placement, panda, given)
        counts[given] = (round(m.distance, 6), m.distance_readings)
    assert counts == {
        None: (0.05, 1),
        0.05: (0.05, 1),  # that of the recording, most likely
        (0.05, 0.05): (0.05, 2),
        0.0499: (0.0499, 2),
        0.0496: (0.0496, 1),
        (0.0496, 0.04965): (0.049625, 2),
    }


def test_a_distance_computed_by_numpy_is_said_in_the_verdict(panda, session):
    """As a program's, or the guide's, whose recordings never saw a file."""
    (front,) = mukca.read_placements(session / "front")
    front = replace(front, distance=np.float64(front.distance), readings=())
    found = mukca.calibrate(panda, [front], method="paper")
    premise = next(one for one in found.verdict.rests_on if one.name == "distance")
    assert "the 50 mm in placement.json" in premise.text


def test_a_size_is_doubted_until_its_distance_was_read_twice():
    assert size_level(0.0055, 1e-3, 0.05, readings=1) == "warning"
    assert size_level(0.0055, 1e-3, 0.05, readings=2) is None
    assert size_level(0.0030, 1e-3, 0.05, readings=1) is None  # as arms are
    assert size_level(0.0080, 1e-3, 0.05, readings=2) == "error"  # three deviations


def test_right_distances_are_seldom_doubted_and_wrong_ones_mostly_are():
    generator = np.random.default_rng(0)
    arms, measured = generator.normal(0, 0.002, 4000), generator.normal(0, 1e-3, 4000)
    sizes = arms + measured
    doubted = np.mean([size_level(s, 1e-3, 0.05) is not None for s in sizes])
    assert doubted < 0.08
    wrong = [size_level(s + 0.5 / 50, 1e-3, 0.05) is not None for s in sizes]
    assert np.mean(wrong) > 0.95
