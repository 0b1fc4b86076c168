"""``mukca check``: what it says, and never a circle."""

import json
import re
from shutil import copytree

import numpy as np
import pytest
from altered import write_rows
from cases import by_table

pytestmark = pytest.mark.slow


@pytest.fixture
def run(command):
    def run(*words):
        status, out, err = command(*words)
        return status, out + err

    return run


@pytest.fixture
def copy(session, tmp_path):
    return copytree(session, tmp_path / "session")


def thinned(folder, *counts):
    for socket, count in enumerate(counts):
        file = folder / f"hole_{socket}.csv"
        lines = file.read_text().splitlines()[:count]
        file.write_text("\n".join(lines) + "\n") if lines else file.unlink()


def test_good_recordings_are_told_by_what_they_would_bring(session, run):
    status, told = run("check", str(session), "--robot", "panda")
    assert status == 0 and "Nothing wrong was seen" in told
    assert "In all 72 samples in 3 placements. By a quick fit, a distance" in told
    assert "sockets 50 mm apart (by the recording)" in told


def test_one_place_asks_for_another_to_pass(session, run):
    said = "for PASS record another"
    for folder, alone in ((session / "front", True), (session, False)):
        _, told = run("check", str(folder), "--robot", "panda")
        assert (said in told) == alone


def test_a_wrong_distance_is_told_before_the_fit(session, command):
    words = ["check", session, "--robot", "panda", "--distance", "0.12", "--json"]
    status, out, told = command(*words)
    assert status == 1 and "the sockets are more likely 50.0 mm apart than 120.0" in told
    found = json.loads(out)
    assert found["findings"][0]["code"] == "scale"
    assert found["scale"]["value"] == pytest.approx(1.4, abs=0.02)
    assert found["placements"][0]["distance_source"] == "given"


def test_a_distance_by_which_no_fit_settles_is_an_error(session, command):
    words = ["check", session / "front", "--robot", "panda", "--distance", "0.5", "--json"]
    status, out, told = command(*words)
    assert json.loads(out)["scale"] is None and "does not settle" not in told
    assert status == 1 and "FAIL" in told
    assert "error: " in told and "the sockets are more likely" in told


def test_what_was_measured_and_how_well_is_heeded(session, copy, run):
    """Front's and left's sockets 0 are 427.2 mm apart in truth."""
    robot = ("--robot", "panda")
    rough = ["check", str(session), *robot, "--distance", "0.0504"]
    assert "longer (+- 0.07 %) than its model" in run(*rough)[1]
    status, told = run(*rough, "--distance-deviation", "0.0005")
    assert status == 0 and "No error was seen; 3 remarks." in told
    status, told = run(*rough, "--known", "front:0-left:0=0.4272")
    assert "likely 50.0 mm apart than 50.4" in told
    status, told = run(*rough[:-2], "--known", "front:0-left:0=0.4572")
    assert status == 1 and "these sockets are 427." in told and "--known session/front:0" in told
    thinned(copy / "front", 12, 0)
    words = ["check", str(copy), *robot, "--known", "front:0-left:0=0.4272"]
    assert run(*words)[0] == 0 and "of the arm's shape, not of its size" in run(*words[:-2])[1]


@by_table("counts", "status", "words")
def test_too_little_is_told(copy, run, counts, status, words):
    thinned(copy / "front", *counts)
    got, told = run("check", str(copy / "front"), "--robot", "panda")
    assert got == status, told
    assert words in told and ("NOT ENOUGH DATA: Only 3 samples" in told) == (status == 3)
    assert "Nothing wrong" not in told and "mukca check" not in told


@pytest.mark.parametrize("counts", [(6, 6), (3, 3)])
def test_few_samples_are_told_as_solve_does(copy, run, tmp_path, counts):
    """They bar no calibration that is better than the nominal model."""
    thinned(copy / "front", *counts)
    words = str(copy / "front"), "--robot", "panda"
    status, told = run("check", *words)
    decided, solved = run("solve", *words, "--out", str(tmp_path / "calibrated"))
    is_better = "USE IT" in solved
    assert is_better or (decided == 3 and "record at least 10 in each" in " ".join(solved.split()))
    assert is_better == ("better than the nominal model (" in told) == (counts == (6, 6))
    assert f"only {counts[0]} samples in a socket" in told.lower()
    assert status == (0 if is_better else 3)


def test_what_is_left_out_is_a_remark(copy, run):
    (copy / "empty").mkdir()
    status, told = run("check", str(copy), "--robot", "panda")
    assert status == 0 and "session/empty: an empty folder among the placements is left" in told
    assert "No error was seen; 1 remark." in told and "Nothing wrong" not in told
    (copy / "left" / "hole_0.csv").write_text("no numbers\n")
    status, told = run("check", str(copy), "--robot", "panda")
    assert "; the placement is left out" in told and "No error was seen; 2 remarks" in told


@pytest.mark.parametrize(
    ("columns", "status", "words"),
    [
        (lambda q: q * [1, 1, 1, -1, 1, 1, 1], 1, "joint 4 (panda_joint4) looks sign-flipped"),
        (lambda q: q + np.outer(q[:, 1], np.eye(7)[3]), 1, "with panda_joint4 - panda_joint2 for"),
        (lambda q: 2.5 * np.sin(3 * q), 2, "(is it another robot?), in the order of the chain"),
    ],
)
def test_readings_outside_the_limits_are_named_by_their_cause(copy, run, columns, status, words):
    """Readings that no cause explains are refused."""
    for file in copy.glob("*/hole_*.csv"):
        rows = columns(np.loadtxt(file, delimiter=","))
        write_rows(file, rows.tolist())
    got, told = run("check", str(copy), "--robot", "panda")
    assert (got, words in told, "outside its limits" in told) == (status, True, True), told


def test_a_placement_of_few_samples_is_none_to_train_on(copy, run):
    thinned(copy / "right", 3, 3)
    _, told = run("check", str(copy), "--robot", "panda")
    assert "To solve with two of them only, take session/front and session/left" in told


def test_a_wrong_distance_has_one_figure(recordings, run):
    folders = [str(recordings / "panda_1" / name) for name in ("front", "right")]
    _, told = run("check", *folders, "--robot", "panda", "--distance", "0.052")
    verdict = next(line for line in told.splitlines() if line.startswith("NOT ENOUGH"))
    assert set(re.findall(r"sockets are (\S+ mm)", verdict)) == {"49.8 mm"}
    assert set(re.findall(r"(\d+\.\d+) % (?:too|longer|off)", verdict)) == {"4.43"}


def test_a_part_with_one_socket_or_sample_serves_beside_a_whole_one(copy, run):
    """As a session leaves it behind whose base moved before the first change of the sockets."""
    thinned(copy / "front", 12, 1)
    parts = [str(copy / name) for name in ("front", "left")]
    status, told = run("check", *parts, "--robot", "panda")
    assert status == 0, told
    assert "front: socket 1 has one sample, which is left out" in told
    calibration = ["solve", *parts, "--robot", "panda", "--out", str(copy.parent / "calibrated")]
    status, told = run(*calibration)
    assert status in (0, 1, 3) and "12  " in told, told


@pytest.mark.parametrize("distance", ["0.025", "0.055", "0.1"])
def test_a_distance_that_is_far_off_bars_a_calibration(session, run, distance):
    status, told = run("check", str(session / "front"), "--robot", "panda", "--distance", distance)
    assert status == 1 and told.startswith("FAIL"), told
    assert "the sockets are more likely" in told
