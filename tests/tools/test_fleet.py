"""Many arms in one go: what each row says, and that a broken arm stops no other."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from altered import moved, turned, write_samples
from kept import says

import mukca

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def fleet(session, tmp_path_factory):
    """arm-1 twice alike, arm-2 with a joint that slipped in between, arm-3 with a bad file."""
    folder = tmp_path_factory.mktemp("fleet") / "arms"
    for arm in ("arm-1", "arm-2"):
        for date in ("2026-05-02", "2026-06-01"):
            for name in ("front", "left"):
                shutil.copytree(session / name, folder / arm / date / name)
    turned(folder / "arm-1/2026-06-01", 0, 0.1)  # with its base: no samples are the same
    turned(folder / "arm-2/2026-06-01", 3, 0.01)
    shutil.copytree(session / "front", folder / "arm-3/front")
    for turns in (2, 3):
        turned(folder / f"arm-{turns}", 0, 0.1 * turns)
    (folder / "arm-3/front/hole_1.csv").write_text("a,b\n1,2\n")
    (folder / "notes").mkdir()
    return folder


def test_a_fleet_is_calibrated_and_compared(fleet, tmp_path, answer):
    out = tmp_path / "out"
    words = ("--robot", "panda", "--method", "paper", "--out", out, "--processes", "1")
    result = answer("fleet", fleet, *words, status=1)
    assert json.loads((out / "fleet.json").read_text()) == result
    one, two, three = result["arms"]
    assert [row["name"] for row in one["sessions"]] == ["2026-05-02", "2026-06-01"]
    assert all(
        row["held_out"] and row["calibrated"] < row["nominal"] / 4 for row in one["sessions"]
    )
    assert [check["change"] for check in one["checks"]] == ["valid"]
    (check,) = two["checks"]
    assert check["status"] == "fail" and check["changed"]
    assert check["change"] == "panda_joint4 changed by 0.57 deg"
    assert two["again"].startswith("Load the new calibrated.urdf")  # by a session of full size
    assert three["sessions"] == [] and "hole_1.csv" in three["error"]
    assert "Mend the recordings" in three["again"]
    check_parameters(result["parameters"], [one["sessions"][1], two["sessions"][1]])
    calibrated, since = out / "arm-2/2026-05-02", fleet / "arm-2/2026-06-01"
    command = f"mukca rezero {calibrated} {since}/front {since}/left --joint panda_joint4"
    assert check["advice"] == f"This finds the joint's new zero: {command}"
    for session in one["sessions"]:
        assert Path(session["outputs"]["urdf"]).is_file()
    page = (out / "fleet.html").read_text()
    says("fleet", page)
    assert page.count("changed by 0.57 deg since 2026-05-02; calibrated: PASS") >= 1
    links = re.findall(r'href="([^":]+)"', page)
    assert links == ["arm-1/2026-06-01/report.html", "arm-2/2026-06-01/report.html"]
    assert all((out / link).is_file() for link in links)


@pytest.fixture(scope="module")
def months():
    """A calibration by 2 x 24 samples in June, and placements for checks by 6 + 6."""
    robot = mukca.load_robot("panda")
    _, placements = mukca.simulate_recordings(robot, 5, samples=12, seed=7)
    rows = (0, 1, 2, 3, 4, 5, 12, 13, 14, 15, 16, 17)
    checks = [replace(p, samples=tuple(p.samples[i] for i in rows)) for p in placements[3:]]
    return placements[:3], checks


def test_a_session_too_small_to_calibrate_checks_the_calibration_that_stands(
    months, tmp_path, answer
):
    """Whatever changed is told in its month, and no other arm is; a missed month is told too."""
    june, (july, august) = months
    slipped = moved(august, august.positions - 0.003 * (np.arange(7) == 3))
    lasts = {"changes": slipped, "stays": august, "away": None}
    for turns, (arm, last) in enumerate(lasts.items()):
        sessions = {f"2026-06-01/{name}": p for name, p in zip("abc", june, strict=True)}
        sessions |= {"2026-07-01/check": july, "2026-08-03/check": last}
        for name, placement in sessions.items():
            if placement is not None:  # with its base turned: no samples are the same
                q = placement.positions + 0.1 * turns * (np.arange(7) == 0)
                write_samples(tmp_path / "fleet" / arm / name, moved(placement, q))
    words = ("--robot", "panda", "--processes", "1", "--out", tmp_path / "out")
    result = answer("fleet", tmp_path / "fleet", *words, status=1)
    told = [(row["arm"], row["session"], row["text"]) for row in result["months"]]
    june, july = ("2026-06-01", "calibrated: PASS"), ("2026-07-01", "valid")
    change = "panda_joint4 changed by 0.17 deg since 2026-06-01"
    lasts = {
        "changes": ("2026-08-03", change),
        "away": ("2026-08", "not checked since 2026-07-01"),
        "stays": ("2026-08-03", "valid"),
    }
    assert told == [(arm, *row) for arm, last in lasts.items() for row in (last, july, june)]
    assert [arm["name"] for arm in result["arms"] if "again" in arm] == ["changes"]
    assert all(len(arm["sessions"]) == 1 for arm in result["arms"])  # June's stands
    assert (tmp_path / "out/fleet.html").read_text().count('class="panel"') == 3
    assert all((row["mean_absolute_error"] or 0) < 2e-4 for row in result["months"][1:])


def check_parameters(rows, sessions):
    """Each parameter over all arms, by hand."""
    assert len(rows) == len(sessions[0]["parameters"]) > 40
    for k, row in enumerate(rows):
        changes = [session["parameters"][k]["change"] for session in sessions]
        assert row["name"] == sessions[0]["parameters"][k]["name"] and row["arms"] == 2
        assert row["mean"] == pytest.approx(np.mean(changes))
        assert row["spread"] == pytest.approx(np.std(changes, ddof=1), abs=1e-15)
        off = [abs(change - np.mean(changes)) for change in changes]
        assert abs(row["change"] - row["mean"]) == pytest.approx(max(off), abs=1e-12)


@pytest.mark.parametrize(
    ("place", "told"),
    [("nowhere", "no such folder"), ("arm-1/2026-05-02", "of one arm"), ("notes", "no arm's")],
)
def test_a_folder_that_is_no_fleet_is_told(fleet, tmp_path, refused, place, told):
    refused(told, "fleet", fleet / place, "--robot", "panda", "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_error_curves_of_arms_of_one_type_are_compared(ur10_points, tmp_path, command):
    head, *rows = ur10_points.read_text().splitlines()
    numbers = np.array([row.split(",") for row in rows[::8]], float)
    for arm in ("a", "b"):  # the same poses under two trackers
        (folder := tmp_path / "fleet" / arm / "points").mkdir(parents=True)
        numbers[:, 8] += 0.1
        np.savetxt(folder / "points.csv", numbers, "%.17g", ",", header=head, comments="")
    words = ["fleet", tmp_path / "fleet", "--out", tmp_path / "out", "--robot", "ur10", "--json"]
    words += ["--flange", "tool0", "--ball", "0", "0", "0.05", "--processes", "1"]
    (pair,) = json.loads(command(*words)[1])["curves"]
    assert (pair["a"], pair["b"]) == ("a", "b")
    assert all(row["difference"] < 1e-7 for row in pair["joints"])


def test_arms_with_the_samples_of_another_do_not_pass(fleet, session, tmp_path, answer):
    for name in ("arm-1/front", "arm-2/July/front", "arm-4/May/left", "arm-4/July/left"):
        shutil.copytree(session / name.rpartition("/")[2], tmp_path / "fleet" / name)
    rows = np.loadtxt(tmp_path / "fleet/arm-1/front/hole_0.csv", delimiter=",")
    np.savetxt(tmp_path / "fleet/arm-1/front/hole_0.csv", rows[::-1], delimiter=",", fmt="%.9f")
    shutil.copytree(fleet / "arm-2/2026-05-02", tmp_path / "fleet/arm-3")
    words = ("--robot", "panda", "--method", "paper", "--processes", "1", "--out", tmp_path / "out")
    one, two, three, four = answer("fleet", tmp_path / "fleet", *words, status=1)["arms"]
    assert not one["sessions"] and "are those of arm arm-2: copied?" in one["error"]
    assert not two["sessions"] and "are those of arm arm-1: copied?" in two["again"]
    assert "error" not in three and len(three["sessions"]) == 1  # calibrated all the same
    assert "are those of another of its placements: copied?" in four["error"]


def test_two_arms_in_one_folder_fail_with_their_cause(tmp_path, answer):
    for name, seed in (("a", 1), ("b", 2)):
        robot = mukca.load_robot("panda")
        _, (one,) = mukca.simulate_recordings(robot, 1, samples=12, seed=seed, rotation=0.012)
        write_samples(tmp_path / "fleet" / "mixed" / name, one)
    words = ("--robot", "panda", "--processes", "1", "--out", tmp_path / "out")
    result = answer("fleet", tmp_path / "fleet", *words, status=1)
    (row,), means = result["arms"], result["parameters"]
    (last,) = row["sessions"]
    assert last["status"] == "fail" and last["parameters"] and means == []
    assert row["again"].startswith("Record a again") and "Most probable cause" in row["again"]


def test_what_to_do_goes_with_its_reason(session, tmp_path, answer):
    """The page does not show the command that would tell it."""
    shutil.copytree(session / "front", tmp_path / "fleet/arm-1/front")
    (tmp_path / "fleet/arm-1/front/placement.json").unlink()
    words = ("--robot", "panda", "--method", "paper", "--out", tmp_path / "out")
    (row,) = answer("fleet", tmp_path / "fleet", *words, "--processes", "1", status=3)["arms"]
    assert row["again"].startswith("Measure the sockets' distance, and type it")
    assert "only the sockets' distance" in row["again"]
