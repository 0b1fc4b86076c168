"""Points of an instrument on the command line: solve, validate, check, and bad files."""

import html
import json
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from altered import moved, write_rows
from calibrated_arm import pose_at, with_ball
from cases import by_table
from worlds import measured_points

import mukca
from mukca.solver.identification.robot import nominal_balls
from mukca.tools.cli import main

pytestmark = pytest.mark.slow


def write_points(placement, folder):
    rows = [(*sample.position, *sample.point) for sample in placement.samples]
    write_rows(folder / "points.csv", rows, (*placement.joint_names, "x", "y", "z"))


@pytest.fixture(scope="module")
def measured(true_panda, shared):
    """Two placements of one instrument's frame, and one of another's."""

    def make(folder):
        generator = np.random.default_rng(2)
        frames = [pose_at(generator.uniform(-2, 2, 3), np.full(3, 2.0 * k)) for k in range(2)]
        for name, frame in (("train", 0), ("test", 0), ("later", 1)):
            points = measured_points(true_panda, frames[frame], generator, samples=45, noise=3e-5)
            write_points(points, folder / name)

    return shared("measured", make)


@pytest.fixture(scope="module")
def solved(measured, tmp_path_factory):
    out = tmp_path_factory.mktemp("points") / "out"
    words = [str(measured / "train"), "--test", str(measured / "test"), "--robot", "panda"]
    words += ["--without", "compliance", "transmission", "--out", str(out), "--json"]
    with redirect_stdout(StringIO()) as text:
        main(["solve", *words])
    return out, json.loads(text.getvalue())


def test_solve_judges_held_out_points_in_the_frame_trained_on(solved):
    out, result = solved
    train, test = result["placements"]
    for row in (train, test):
        assert row["kind"] == "points" and row["distance"] is None
        assert row["calibrated"]["distance_error"] is None
    assert test["nominal"]["mean_absolute_error"] > 1e-3
    assert test["calibrated"]["mean_absolute_error"] < 1e-4
    assert result["distorted"] == []
    assert "measured coordinates" in (out / "report.json").read_text()


def test_validate_fits_the_frame_to_other_points_of_it(solved, measured, command):
    """The instrument stood elsewhere, and the error is that of the other held-out points."""
    out, result = solved
    words = ("validate", out / "calibration.json", measured / "later" / "points.csv", "--json")
    (row,) = json.loads(command(*words)[1])["placements"]
    held = result["summary"]["test"]["calibrated"]["mean_absolute_error"]
    assert row["kind"] == "points" and row["role"] == "test"
    assert row["calibrated"]["mean_absolute_error"] == pytest.approx(held, rel=0.5)


def test_points_of_another_probe_refit_its_tip(solved, true_panda, tmp_path, command):
    """The shift is said, and a zero that moved is not taken for another probe."""
    out, _ = solved
    generator, frame = np.random.default_rng(4), pose_at(np.zeros(3), np.ones(3))
    probe = with_ball(true_panda, true_panda.origins[-1, :3] + [0.012, -0.016, 0.01])
    points = measured_points(probe, frame, generator, samples=45, noise=3e-5)
    write_points(points, tmp_path / "probe")
    words = ("validate", out / "calibration.json", tmp_path / "probe" / "points.csv")
    status, text, _ = command(*words)
    assert status == 0, text
    assert "The tip was refitted: it sits 22.37 mm from the calibration's" in text
    points = measured_points(true_panda, frame, generator, samples=45, noise=3e-5)
    write_points(moved(points, points.positions - 5e-3 * np.eye(7)[3]), tmp_path / "lost")
    status, text, _ = command(*words[:2], tmp_path / "lost" / "points.csv")
    assert status == 1 and "drifted" in text and "tip was refitted" not in text


def test_a_flange_that_hardly_turns_has_the_errors_of_its_points(
    solved, true_panda, tmp_path, command
):
    """Neither the frame nor the target is told by such points, and both together are."""
    out, _ = solved
    generator, frame = np.random.default_rng(6), pose_at(np.zeros(3), np.ones(3))
    points = measured_points(true_panda, frame, generator, samples=60, noise=0.0)
    q = points.positions[:1] + generator.normal(0, 0.01, points.positions.shape)
    balls = nominal_balls(true_panda, q) + generator.normal(0, 1e-4, (60, 3))
    rows = np.hstack([q, balls]).tolist()
    write_rows(tmp_path / "small" / "points.csv", rows, (*points.joint_names, "x", "y", "z"))
    words = ("validate", out / "calibration.json", tmp_path / "small" / "points.csv", "--json")
    text = command(*words)[1]
    (row,) = json.loads(text)["placements"]
    assert row["nominal"]["mean_absolute_error"] < 3e-4
    assert row["calibrated"]["mean_absolute_error"] < 3e-4


def test_check_and_info_name_the_points(measured, command):
    status, out, _ = command("info", measured / "train")
    assert status == 0 and "45 points that an instrument measured" in out
    status, out, _ = command("check", measured / "train", "--robot", "panda")
    assert status == 0 and "Measured points need no socket" in out


def test_a_scale_that_no_instrument_is_off_by_is_another_robots(measured, tmp_path, command):
    header, *rows = (measured / "train" / "points.csv").read_text().splitlines()
    words = np.array([row.split(",") for row in rows])
    larger = (1.45 * words[:, -3:].astype(float)).astype(str)
    lines = [",".join(row) for row in np.column_stack([words[:, :-3], larger])]
    (tmp_path / "points.csv").write_text("\n".join([header, *lines]))
    status, out, _ = command("check", tmp_path / "points.csv", "--robot", "panda")
    assert status == 1 and "does --robot name this arm?" in out.splitlines()[0]


@by_table("header", "row", "words")
def test_a_malformed_file_is_refused_by_line(tmp_path, header, row, words):
    (tmp_path / "points.csv").write_text(f"{header}\n{row}\n")
    with pytest.raises(mukca.MukcaError, match=words):
        mukca.read_placements(tmp_path)[0]


def test_the_papers_method_refuses_points(measured, refused):
    words = ("solve", measured / "train", "--robot", "panda", "--method", "paper")
    refused("--method paper knows sockets only", *words)


def test_true_errors_within_their_limit_pass_without_any_socket(solved):
    out, _ = solved
    verdict = json.loads((out / "report.json").read_text())["verdict"]
    assert verdict["status"] == "pass"
    (row,) = [row for row in verdict["reasons"] if row["name"] == "distance_error"]
    assert (
        row["status"] == "not evaluated"
        and "instrument measured the held-out points" in row["reason"]
    )


def test_no_step_asks_for_a_distance_of_sockets_that_are_not_there(measured, command, tmp_path):
    header, *lines = (measured / "train/points.csv").read_text().splitlines()
    rows = [[float(x) for x in line.split(",")] for line in lines]
    scaled = [[*row[:-3], *(1.02 * x for x in row[-3:])] for row in rows]
    write_rows(tmp_path / "small/points.csv", scaled, [header])
    out = tmp_path / "out"
    words = ("--robot", "panda", "--without", "compliance", "transmission", "tilt", "--out", out)
    command("solve", tmp_path / "small", *words)
    report = json.loads((out / "report.json").read_text())
    assert report["verdict"]["status"] == "fail"
    assert [step for step in report["todo"] if "--distance " in step["command"]] == []
    assert [step for step in report["todo"] if step["command"].startswith("mukca record")] == []


def test_a_sample_that_an_instrument_measured_is_a_point_and_in_no_socket(measured):
    (placement,) = mukca.read_placements(measured / "train")
    assert [sample.named for sample in placement.samples[:2]] == ["point 1", "point 2"]


def test_poses_that_do_not_tell_are_the_flanges_where_it_is_said(
    solved, measured, tmp_path, command, refused
):
    lines = (measured / "later" / "points.csv").read_text().splitlines()[:9]
    rows = [lines[0] + ",qx,qy,qz,qw", *(f"{line},0,0,0,1" for line in lines[1:])]
    (tmp_path / "poses.csv").write_text("\n".join(rows) + "\n")
    for words in (["validate", solved[0], tmp_path], ["check", "--robot", "panda", tmp_path]):
        refused("--flange-poses", *words)
        status, out, _ = command(*words, "--flange-poses")
        assert status != 2 and (words[0] == "check" or "mrad" in out)


def test_solve_keeps_the_recording_of_a_table(measured, tmp_path, answer):
    """It is another form of what was solved, for every other verb."""
    lines = (measured / "train" / "points.csv").read_text().splitlines()[1:]
    table = tmp_path / "t.txt"
    table.write_text("\n".join(line.replace(",", "\t") for line in lines))
    words = ["--robot", "panda", "--without", "compliance", "transmission"]
    columns = ["--columns", "q=1..7", "x=8", "y=9", "z=10"]
    out = tmp_path / "out"
    told = answer("solve", table, *words, "--out", out, *columns, status=0)
    (placement,) = told["placements"]
    stored = json.loads((out / "calibration.json").read_text())["data"]
    folder = Path(stored[0]["files"][0]).parent
    assert folder.is_relative_to(out)
    again = answer("solve", folder, *words, status=0)
    assert placement["calibrated"] == again["placements"][0]["calibrated"]
    told = answer("validate", out, table, *columns, status=3)
    assert told["placements"][0]["role"] == "train"


def test_validate_tells_every_error_that_it_counts(solved, measured, tmp_path, command):
    """On the terminal, in JSON, and on the page."""
    (later,) = mukca.read_placements(measured / "later")
    swapped = later.positions[:, [0, 1, 4, 3, 2, 5, 6]]
    write_points(moved(later, swapped), tmp_path / "later")
    words = ("validate", solved[0], tmp_path / "later", "--out", tmp_path / "page", "--json")
    status, out, told = command(*words)
    verdict = json.loads(out)["verdict"]
    errors = [finding for finding in verdict["findings"] if finding["level"] == "error"]
    assert status == 1 and errors
    page = html.unescape((tmp_path / "page" / "report.html").read_text())
    for finding in errors:
        assert finding["text"] in " ".join(told.split()) and finding["text"] in page


@pytest.mark.parametrize("form", ["samples", "holes"])
def test_a_conversion_that_would_lose_measured_points_is_refused(refused, tmp_path, form):
    file = tmp_path / "t.csv"
    file.write_text("A1,A2,x,y,z\n0.1,-1.2,0.5,0.1,0.3\n0.2,-1.1,0.4,0.1,0.3\n")
    out = tmp_path / "out"
    refused("would lose; give --to points", "convert", file, "--to", form, "--out", out)
    assert not out.exists()


def test_of_two_forms_in_a_folder_the_named_file_is_read(tmp_path):
    rows = "A1,A2,x,y,z\n0.1,-1.2,0.5,0.1,0.3\n0.2,-1.1,0.4,0.1,0.3\n"
    for name in ("points.csv", "samples.csv"):
        (tmp_path / name).write_text(rows)
    (placement,) = mukca.read_placements(tmp_path / "points.csv")
    assert placement.samples[1].point == (0.4, 0.1, 0.3)
    with pytest.raises(mukca.MukcaError, match="holds both"):
        mukca.read_placements(tmp_path)
