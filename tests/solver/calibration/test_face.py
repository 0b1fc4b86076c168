"""What a person tries first on a calibration, a robot and a placement works, or says what does."""

from dataclasses import replace

import numpy as np
import pytest
from cases import by_table

import mukca


@pytest.fixture(scope="module")
def placements(session):
    return mukca.read_placements(session)


@pytest.fixture(scope="module")
def saved(panda, placements, tmp_path_factory):
    """A calibration by the front placement, and the folder that it was saved to."""
    folder = tmp_path_factory.mktemp("face") / "calibrated"
    found = mukca.calibrate(panda, placements[0], test=placements[1:], method="paper")
    found.save(folder)
    return found, folder


def test_a_calibration_is_loaded_by_its_folder_and_has_what_one_looks_for(saved):
    found, folder = saved
    again = mukca.load_calibration(folder)
    q = [0.1, -0.3, 0.2, -1.8, 0.1, 1.5, 0.7]
    assert np.array_equal(again.flange(q), found.flange(q))
    assert again.urdf(folder) == (folder / "calibrated.urdf").read_bytes()
    assert again.parameters == again.document.parameters
    assert again.true_positions(q) == pytest.approx(q)
    with pytest.raises(mukca.MukcaError, match=r"force=True") as stopped:
        found.save(folder)
    assert str(folder) in str(stopped.value)


def test_errors_are_found_by_the_placements_name(saved):
    errors = saved[0].errors
    assert errors["left"] is errors[[e.name.split("/")[-1] for e in errors].index("left")]
    with pytest.raises(mukca.MukcaError, match=r"there are: .*front"):
        errors["nowhere"]


@pytest.mark.parametrize("nothing", [None, 7])
def test_what_is_no_path_is_said(nothing):
    with pytest.raises(mukca.MukcaError, match=r"^(None|7) is no path: give that of calib"):
        mukca.load_calibration(nothing)


def test_what_does_not_fit_is_said(saved):
    found, q = saved[0], np.zeros((3, 7))
    for wrong, said in (
        (np.zeros(6), r"shape \(6,\): panda has 7 joints"),
        (np.zeros((2, 2, 7)), r"shape \(2, 2, 7\): panda has 7 joints"),
        ([0, 0, 0, np.nan, 0, 0, 0], "row 0, 'panda_joint4' is nan"),
    ):
        own = found.calibrated
        for ball in (found.ball, own.ball, own.nominal_ball, own.geometric_ball):
            with pytest.raises(mukca.MukcaError, match=said):
                ball(wrong)
    with pytest.raises(mukca.MukcaError, match="one effort for each position"):
        found.ball(q, np.zeros(7))
    with pytest.warns(UserWarning, match=r"'panda_joint4' is 0, outside its limits -3\.07"):
        found.flange(q)


@by_table("setup", "said")
def test_words_that_mean_nothing_are_said(saved, setup, said):
    with pytest.raises(mukca.MukcaError, match=said):
        saved[0].command([0.4, 0.0, 0.4], **setup)


def test_no_poses_give_no_joints(saved):
    none = np.zeros((0, 4, 4))
    assert saved[0].command(none).shape == saved[0].command_path(none).checked().shape == (0, 7)


def test_a_point_in_millimetres_is_asked_about(saved):
    with pytest.raises(mukca.MukcaError, match="in millimetres"):
        saved[0].command([400.0, 0.0, 40000.0])


def test_a_placement_is_made_of_arrays(panda, placements):
    one = placements[0]
    made = mukca.Placement.of_arrays(
        "mine", one.positions, one.sockets, one.joint_names, distance=one.distance
    )
    by_both = [mukca.calibrate(panda, p, method="paper") for p in (one, made)]
    assert by_both[0].parameters == by_both[1].parameters
    with pytest.raises(mukca.MukcaError, match="do not fit"):
        mukca.Placement.of_arrays("mine", one.positions, one.sockets[:-1])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda q, s: (np.where(np.arange(7) == 1, np.nan, q), s), r"positions\[0, 1\]: nan"),
        (lambda q, s: (q + 1j, s), "complex"),
        (lambda q, s: (q[:0], s[:0]), "no samples"),
        (lambda q, s: (q, s - 1), "sockets are -1 to 0"),
        (lambda q, s: (q, s + 10**12), "from 0 to 999"),
        (lambda q, s: (q, s + 0.5), "whole numbers"),
        (lambda q, s: (q, ["left"] * len(s)), "sockets: real numbers are expected"),
    ],
)
def test_arrays_that_are_no_samples_are_refused(placements, change, told):
    one = placements[0]
    with pytest.raises(mukca.MukcaError, match=told):
        mukca.Placement.of_arrays("mine", *change(one.positions, one.sockets))


def test_what_is_no_path_nor_number_is_refused(panda, placements):
    for paths in (["front"], None):
        with pytest.raises(mukca.MukcaError, match="no path; name the folders one by one"):
            mukca.read_placements(paths)
    with pytest.raises(mukca.MukcaError, match="no driver is called 'None'"):
        mukca.open_driver(None)
    one = placements[0]
    first = replace(one.samples[0], position=(np.nan,) * 7)
    with pytest.raises(mukca.MukcaError, match="nan is no number"):
        mukca.calibrate(panda, replace(one, samples=(first, *one.samples[1:])))


def test_placements_may_come_one_by_one(panda, placements):
    found = mukca.calibrate(panda, (p for p in placements[:1]), method="paper")
    assert found.parameters == mukca.calibrate(panda, placements[0], method="paper").parameters


def test_a_robot_knows_its_limits_and_misspelt_ones_are_offered(panda):
    assert panda.lower[3] == pytest.approx(-3.0718) and panda.upper.shape == (7,)
    with pytest.raises(mukca.MukcaError, match="did you mean 'panda'"):
        mukca.load_robot("Panda")


def test_a_ball_of_ones_own_goes_onto_a_shipped_model(panda):
    own = mukca.load_robot("panda", flange="panda_hand_tcp", ball=(0.0, 0.0, 0.03))
    assert own.ball_joint.origin.xyz == (0.0, 0.0, 0.03) and own.tip != panda.tip


def test_joints_outside_their_limits_are_said(saved):
    q = np.array([3.5, -0.3, 0.2, -1.8, 0.1, 1.5, 0.7])
    for ask in (saved[0].ball, saved[0].true_positions, saved[0].flange):
        with pytest.warns(UserWarning, match=r"'panda_joint1' is 3.5, outside its limits -2.897"):
            ask(q)
