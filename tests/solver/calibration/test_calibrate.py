"""The Python face: what a notebook does, and what it is told when it does something else."""

import json
import subprocess
import sys
from pathlib import Path

import lazy_loader
import numpy as np
import pytest
from altered import moved
from cases import by_table

import mukca
from mukca.tools.cli import main


@pytest.fixture(scope="module")
def recordings(session):
    train = mukca.read_placements(session / "front")
    return train, mukca.read_placements(str(session / "left"), str(session / "right"))


@pytest.fixture(scope="module")
def calibration(recordings):
    train, test = recordings
    return mukca.calibrate(mukca.load_robot("panda"), train, test=test)


@pytest.fixture(scope="module")
def saved(calibration, tmp_path_factory):
    folder = tmp_path_factory.mktemp("face") / "calibrated"
    calibration.save(folder)
    return folder


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


def test_every_public_name_is_there():
    assert all(getattr(mukca, name) is not None for name in mukca.__all__)
    assert set(mukca.__all__) <= set(dir(mukca))
    with pytest.raises(AttributeError, match="calibrat"):
        _ = mukca.calibrat


@pytest.mark.slow
def test_errors_are_there_per_placement_and_as_a_table(calibration, recordings):
    roles = {e.name.split("/")[-1]: e.role for e in calibration.errors}
    assert roles == {"front": "train", "left": "test", "right": "test"}
    left = calibration.errors[1]
    assert left.calibrated.mean_absolute_error < 2e-4 < left.nominal.mean_absolute_error
    assert calibration.errors.summary.test.removed_error > 0.9
    table = str(calibration)
    assert "panda" in table and "left" in table and len(table.splitlines()) < 25
    assert f"{1e3 * left.calibrated.mean_absolute_error:.3f}" in table
    assert "(as the recording says)" in table and "Verdict: PASS" in table
    train, test = recordings
    how = {"distance": 0.051, "method": "paper"}
    wrong = repr(mukca.calibrate(calibration.robot, train, test=test, **how))
    assert "Distance of the sockets: 51 mm (as given)" in wrong and "Verdict: FAIL" in wrong
    assert "warning: all placements: more likely the sockets" in wrong


@pytest.mark.slow
def test_the_command_line_is_a_layer_over_it(calibration, saved, session, tmp_path):
    """What `mukca solve --out` writes is what `save` writes, but for names and times."""
    out = tmp_path / "by_command"
    words = ["solve", "front", "--test", "left", "right", "--robot", "panda", "--out", str(out)]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(session)
        assert main(words) == 0
    pages = {"report.html", "report.json"}
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


def test_what_is_saved_is_loaded_again(calibration, saved, session):
    again = mukca.load_calibration(saved / "calibration.json")
    q = mukca.read_placements(session / "front")[0].positions
    assert np.array_equal(again.ball(q), calibration.ball(q))
    assert again.errors.as_dict() == calibration.errors.as_dict()
    validated = again.validate(mukca.read_placements(session))
    assert [e.role for e in validated] == ["train", "test", "test"]
    assert validated.as_dict()["placements"][1]["calibrated"] == pytest.approx(
        calibration.errors.as_dict()["placements"][1]["calibrated"]
    )


@by_table("settings", "words")
def test_bad_settings_are_told_in_one_line(recordings, settings, words):
    with pytest.raises(mukca.MukcaError) as told:
        mukca.calibrate(mukca.load_robot("panda"), recordings[0], **settings)
    assert words in str(told.value) and "\n" not in str(told.value)


def test_other_bad_arguments_are_told_in_one_line(calibration, recordings, tmp_path):
    robot = mukca.load_robot("panda")
    for bad in (
        lambda: mukca.load_robot("robby"),
        lambda: mukca.load_robot("panda", flange="panda_link8"),
        lambda: mukca.read_placements(tmp_path / "nowhere"),
        lambda: mukca.calibrate(robot, []),
        lambda: mukca.calibrate(mukca.load_robot("ur5e"), recordings[0]),
        lambda: mukca.calibrate("panda", recordings[0]),
        lambda: mukca.calibrate(robot, "recordings/front"),
        lambda: mukca.calibrate(robot, recordings[0], test=["recordings/left"]),
        lambda: calibration.validate("recordings/left"),
        lambda: calibration.validate([]),
        lambda: calibration.ball(np.zeros(3)),
        lambda: calibration.ball(np.full(7, 90)),
        lambda: calibration.ball("home"),
        lambda: mukca.load_calibration(tmp_path / "none.json"),
        lambda: mukca.open_driver("nobody:1.2.3.4"),
        lambda: mukca.export(calibration, "dh", tmp_path / "dh.json", lik="other.json"),
        lambda: mukca.simulate_recordings(robot, 2, sed=1),
    ):
        with pytest.raises(mukca.MukcaError) as told:
            bad()
        assert "\n" not in str(told.value)


def test_what_is_printed_in_a_notebook_is_short(calibration, recordings):
    values = (calibration.robot, recordings[0][0], calibration, calibration.calibrated)
    for value in values:
        assert len(repr(value)) < 2500, type(value)
    assert len(repr(calibration.robot)) < 100 and "7 joints" in repr(calibration.robot)


def test_a_fit_that_does_not_converge_says_what_is_wrong_in_the_recordings(recordings):
    robot, (placement,) = mukca.load_robot("panda"), recordings[0]
    with pytest.raises(mukca.MukcaError) as told:
        mukca.calibrate(robot, placement, method="paper", max_iterations=1)
    assert "did not converge;" not in str(told.value)
    broken = moved(placement, placement.positions * [1, 0, 1, 1, 1, 1, 1])
    with pytest.raises(mukca.MukcaError, match=r"did not converge; .*is it this robot's model"):
        mukca.calibrate(robot, broken, method="paper", max_iterations=1)
