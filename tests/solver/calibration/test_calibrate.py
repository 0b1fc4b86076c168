"""The Python face: what a person tries first works, or says what does."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import lazy_loader
import numpy as np
import pytest
from altered import moved
from cases import by_table
from threadpoolctl import threadpool_info, threadpool_limits

import mukca
from mukca.tools.cli import main


@pytest.fixture(scope="module")
def placements(session):
    return mukca.read_placements(session)


@pytest.fixture(scope="module")
def calibration(panda, placements):
    return mukca.calibrate(panda, placements[0], test=placements[1:])


@pytest.fixture(scope="module")
def saved(calibration, tmp_path_factory):
    folder = tmp_path_factory.mktemp("face") / "calibrated"
    calibration.save(folder)
    return folder


def test_the_iterations_are_those_of_the_history(calibration):
    document = calibration.document
    assert document.history and document.iterations == document.history[-1].iteration > 0


def test_the_face_loads_nothing_before_it_is_used():
    code = "import sys, mukca; print([m for m in ('numpy', 'casadi', 'rich') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_the_face_costs_less_than_typing_does():
    """Without what an editable installation loads at each start."""
    packages, folder = Path(lazy_loader.__file__).parents[1], Path(mukca.__file__).parent
    code = f"""
import sys
sys.path.append({str(packages)!r})
sys.modules["mukca"] = module = type(sys)("mukca")
module.__path__, module.__file__ = [{str(folder)!r}], {mukca.__file__!r}
exec(open(module.__file__).read(), vars(module), vars(module))
print({{"typing", "ast"}} & set(sys.modules), module.__all__ == {mukca.__all__!r})
"""
    words = [sys.executable, "-I", "-S", "-c", code]
    assert subprocess.run(words, capture_output=True, text=True).stdout == "set() True\n"


def test_a_fit_takes_one_thread_of_blas_and_gives_the_others_back(panda, placements):
    def threads(_=""):
        (blas,) = (pool for pool in threadpool_info() if "numpy" in pool["filepath"])
        counts.append(blas["num_threads"])

    counts = []
    with threadpool_limits(2, "blas"):
        mukca.calibrate(panda, placements[0], progress=threads)
        threads()
        with pytest.raises(mukca.MukcaError):
            mukca.calibrate(panda, [])
        threads()
    *fitting, after, after_error = counts
    assert set(fitting) == {1} and after == after_error == 2


def test_every_public_name_is_there():
    assert all(getattr(mukca, name) is not None for name in mukca.__all__)
    assert set(mukca.__all__) <= set(dir(mukca))
    with pytest.raises(AttributeError, match="calibrat"):
        _ = mukca.calibrat


@pytest.mark.slow
def test_errors_are_there_per_placement_and_as_a_table(calibration, placements):
    roles = {e.name.split("/")[-1]: e.role for e in calibration.errors}
    assert roles == {"front": "train", "left": "test", "right": "test"}
    left = calibration.errors[1]
    assert left.calibrated.mean_absolute_error < 2e-4 < left.nominal.mean_absolute_error
    assert calibration.errors.summary.test.removed_error > 0.9
    table = str(calibration)
    assert "panda" in table and "left" in table and len(table.splitlines()) < 25
    assert f"{1e3 * left.calibrated.mean_absolute_error:.3f}" in table
    assert "(as the recording says)" in table and "Verdict: PASS" in table
    how = {"distance": 0.051, "method": "paper", "test": placements[1:]}
    wrong = repr(mukca.calibrate(calibration.robot, placements[0], **how))
    assert "Distance of the sockets: 51 mm (as given)" in wrong and "DO NOT LOAD IT" in wrong
    assert "warning: all placements: the sockets are more likely" in wrong


@pytest.mark.slow
def test_the_command_line_is_a_layer_over_it(calibration, saved, session, tmp_path):
    """What `mukca solve --out` writes is what `save` writes, but for names and times."""
    out = tmp_path / "by_command"
    words = ["solve", "front", "--test", "left", "right", "--robot", "panda", "--out", str(out)]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(session)
        assert main(words) == 0
    pages = {"report.html", "report.json", "residuals.csv"}
    assert {f.name for f in out.iterdir()} == {f.name for f in saved.iterdir()} | pages
    assert (out / "calibrated.urdf").read_bytes() == (saved / "calibrated.urdf").read_bytes()
    one, other = (json.loads((f / "calibration.json").read_text()) for f in (out, saved))
    assert one.keys() == other.keys()
    same = ("model", "parameters", "placements", "summary", "deflection", "settings", "noise")
    for key in same:
        a, b = one[key], other[key]
        if key == "placements":
            a, b = ([{**row, "name": ""} for row in rows] for rows in (a, b))
        assert a == b, key


def test_what_is_saved_is_loaded_again_by_its_folder(calibration, saved, session):
    again = mukca.load_calibration(saved)
    q = mukca.read_placements(session / "front")[0].positions
    assert np.array_equal(again.ball(q), calibration.ball(q))
    assert np.array_equal(again.flange(q), calibration.flange(q))
    assert again.true_positions(q) == pytest.approx(q)
    assert again.urdf(saved) == (saved / "calibrated.urdf").read_bytes()
    assert again.parameters == again.document.parameters
    with pytest.raises(mukca.MukcaError, match=rf"{saved}.*force=True"):
        calibration.save(saved)
    assert again.errors.as_dict() == calibration.errors.as_dict()
    validated = again.validate(mukca.read_placements(session))
    assert [e.role for e in validated] == ["train", "test", "test"]
    assert validated.as_dict()["placements"][1]["calibrated"] == pytest.approx(
        calibration.errors.as_dict()["placements"][1]["calibrated"]
    )


@by_table("settings", "words")
def test_bad_settings_are_told_in_one_line(panda, placements, settings, words):
    with pytest.raises(mukca.MukcaError) as told:
        mukca.calibrate(panda, placements[0], **settings)
    assert words in str(told.value) and "\n" not in str(told.value)


def test_other_bad_arguments_are_told_in_one_line(panda, calibration, placements, tmp_path):
    for bad in (
        lambda: mukca.load_robot("robby"),
        lambda: mukca.load_robot("panda", ball=(0, 0, 0.1)),
        lambda: mukca.read_placements(tmp_path / "nowhere"),
        lambda: mukca.calibrate(panda, []),
        lambda: mukca.calibrate(mukca.load_robot("ur5e"), placements[0]),
        lambda: mukca.calibrate("panda", placements[0]),
        lambda: mukca.calibrate(panda, "recordings/front"),
        lambda: mukca.calibrate(panda, placements[0], test=["recordings/left"]),
        lambda: calibration.validate("recordings/left"),
        lambda: calibration.validate([]),
        lambda: calibration.ball(np.zeros(3)),
        lambda: calibration.ball(np.full(7, 90)),
        lambda: calibration.ball("home"),
        lambda: mukca.load_calibration(tmp_path / "none.json"),
        lambda: mukca.open_driver("nobody:1.2.3.4"),
        lambda: mukca.export(calibration, "dh", tmp_path / "dh.json", lik="other.json"),
        lambda: mukca.simulate_recordings(panda, 2, sed=1),
    ):
        with pytest.raises(mukca.MukcaError) as told:
            bad()
        assert "\n" not in str(told.value)


def test_what_is_printed_in_a_notebook_is_short(calibration, placements):
    values = (calibration.robot, placements[0], calibration, calibration.calibrated)
    for value in values:
        assert len(repr(value)) < 2500, type(value)
    assert len(repr(calibration.robot)) < 100 and "7 joints" in repr(calibration.robot)


def test_a_fit_that_does_not_converge_says_what_is_wrong_in_the_recordings(panda, placements):
    placement = placements[0]
    with pytest.raises(mukca.MukcaError) as told:
        mukca.calibrate(panda, placement, method="paper", max_iterations=1)
    assert "did not converge;" not in str(told.value)
    broken = moved(placement, placement.positions * [1, 0, 1, 1, 1, 1, 1])
    with pytest.raises(mukca.MukcaError, match=r"did not converge; .*does --robot name this arm"):
        mukca.calibrate(panda, broken, method="paper", max_iterations=1)


def test_errors_are_found_by_the_placements_name(calibration):
    errors = calibration.errors
    assert errors["left"] is errors[[e.name.split("/")[-1] for e in errors].index("left")]
    with pytest.raises(mukca.MukcaError, match=r"there are: .*front"):
        errors["nowhere"]


@pytest.mark.parametrize("nothing", [None, 7])
def test_what_is_no_path_is_said(nothing):
    with pytest.raises(mukca.MukcaError, match=r"^(None|7) is no path: give that of calib"):
        mukca.load_calibration(nothing)


def test_what_does_not_fit_is_said(calibration):
    found, q = calibration, np.zeros((3, 7))
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
def test_words_that_mean_nothing_are_said(calibration, setup, said):
    with pytest.raises(mukca.MukcaError, match=said):
        calibration.command([0.4, 0.0, 0.4], **setup)


def test_no_poses_give_no_joints(calibration):
    none = np.zeros((0, 4, 4))
    assert (
        calibration.command(none).shape == calibration.command_path(none).checked().shape == (0, 7)
    )


def test_a_point_in_millimetres_is_asked_about(calibration):
    with pytest.raises(mukca.MukcaError, match="in millimetres"):
        calibration.command([400.0, 0.0, 40000.0])


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


def test_a_robot_knows_its_limits(panda):
    assert panda.lower[3] == pytest.approx(-3.0718) and panda.upper.shape == (7,)


def test_joints_outside_their_limits_are_said(calibration):
    q = np.array([3.5, -0.3, 0.2, -1.8, 0.1, 1.5, 0.7])
    for ask in (calibration.ball, calibration.true_positions, calibration.flange):
        with pytest.warns(UserWarning, match=r"'panda_joint1' is 3.5, outside its limits -2.897"):
            ask(q)
