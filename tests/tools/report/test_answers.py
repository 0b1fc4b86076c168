"""The answers of a report (use, next, data), and the arm that it draws."""

import json

import numpy as np
import pytest

import mukca
from mukca.tools.cli import main

pytestmark = pytest.mark.slow


def test_the_task_is_answered_place_by_place(document, report):
    errors = report(document)["placements"][1]["quantiles"]["calibrated"]
    answers = {
        tolerance: report(document, "--tolerance-mm", str(1e3 * tolerance))["answers"]["use"]
        for tolerance in (1.01 * errors["max"], 0.99 * errors["max"], 0.99 * errors["p95"])
    }
    assert [use["rows"][1]["answer"] for use in answers.values()] == ["yes", "mostly", "no"]
    assert all(use["rows"][0]["answer"] == "trained on" for use in answers.values())
    document["placements"][1]["calibrated"]["distance_error"] = -2e-3  # the model has shrunk there
    rows = report(document)["answers"]["use"]["rows"]
    assert rows[1]["answer"] == "no" and rows[2]["answer"] != "no"


def test_nothing_is_assumed_of_a_task_that_nobody_named(document, report):
    told = report(document)
    assert told.get("task") is None
    _, *held_out = told["answers"]["use"]["rows"]
    errors = [row["quantiles"]["calibrated"]["max"] for row in told["placements"][1:]]
    assert [row["least"] for row in held_out] == errors
    words = told["answers"]["use"]["text"]
    assert f"serve tasks that allow {1e3 * max(errors):.2f} mm or more" in words
    assert "yes" not in words and "0.5 mm" not in words


def test_what_is_expected_of_distances_is_told_where_none_was_measured(document, report):
    between = report(document)["answers"]["use"]["between"]
    assert between.endswith("since no such distance is known.")
    now = {"value": 6.8e-4, "low": 5e-4, "high": 1.1e-3}
    document["better"] = {"workspace": {"before": now, "now": now, "probability": 0.5}}
    between = report(document)["answers"]["use"]["between"]
    assert "expects 0.68 mm anywhere in the workspace (68 %: 0.50 mm to 1.10 mm)" in between


def test_a_recording_that_is_wrong_comes_first(document, report):
    answers = report(document)["answers"]
    assert (
        "first, see below" not in answers["next"]["text"]
        and "rest on" not in answers["data"]["text"]
    )
    bad = {"level": "error", "code": "moved", "text": "the base moved", "advice": "record it again"}
    for row, said in ((document["placements"][0], True), (document["placements"][1], False)):
        document["checks"] = [{**bad, "where": f"/home/me/{row['name']}/hole_1.csv:12"}]
        answers = report(document)["answers"]
        name = row["name"].split("/")[-1]
        assert answers["next"]["text"].startswith(f"Correct {name} first, see below.")
        words = f"All figures here rest on {name}, trained on."
        assert (words in answers["data"]["text"]) == said
    document["checks"] = [{**bad, "where": "all placements"}]
    answers = report(document)["answers"]
    assert answers["next"]["text"].startswith("Correct front, left and right first, see below.")
    assert "rest on front, trained on" in answers["data"]["text"]


def test_a_placement_alone_leaves_the_same_everywhere(document, report, session, capsys):
    """The terminal and the page say one number by the same words."""
    assert main(["check", str(session), "--robot", "panda", "--json"]) == 0
    told = {row["name"]: row["floor"] for row in json.loads(capsys.readouterr().out)["placements"]}
    answer = report(document)["answers"]["data"]
    floors = {f"session/{row['name']}": row["mean_absolute_error"] for row in answer["floors"]}
    assert floors == told
    low, high = (f"{1e3 * f(told.values()):.3f} mm" for f in (min, max))
    assert f"Fitted alone, the placements leave {low} to {high}: none stands out." in answer["text"]


def test_data_are_not_all_right_where_one_place_leaves_ten_times_what_the_arm_repeats(
    document, report
):
    answer = report(document)["answers"]["data"]
    floors = {row["name"]: row["mean_absolute_error"] for row in answer["floors"]}
    assert not answer["text"].startswith("No")
    worst = max(floors, key=lambda name: floors[name])
    document["settings"]["repeatability_mm"] = 1e2 * floors[worst] * 0.999
    told = report(document)["answers"]["data"]["text"]
    assert told.startswith(f"No: fitted alone, {worst} leaves more than ten times what the arm")


def test_a_joint_that_hardly_moved_is_named(session, tmp_path):
    still = tmp_path / "still/front"
    still.mkdir(parents=True)
    for file in (session / "front").glob("hole_*.csv"):
        rows = [line.split(",") for line in file.read_text().split()]
        text = "\n".join(",".join([*row[:6], "0.1"]) for row in rows)
        (still / file.name).write_text(f"{text}\n")
    words = [str(still), "--robot", "panda", "--method", "paper", "--accept-distorted"]
    main(["solve", *words, "--out", str(tmp_path / "out")])
    told = json.loads((tmp_path / "out/report.json").read_text())["answers"]["next"]
    assert told["joints"] == ["panda_joint7"] and "Turn panda_joint7 more" in told["text"]


def test_the_next_place_is_as_far_as_the_others_and_apart_from_them(calibrated):
    figures = json.loads((calibrated / "report.json").read_text())
    positions = np.array([row["position"] for row in figures["placements"]])
    place = np.array(figures["answers"]["next"]["place"])
    assert np.hypot(*place[:2]) == pytest.approx(np.hypot(*positions[:, :2].T).mean())
    assert place[2] == pytest.approx(positions[:, 2].mean())
    assert place[0] > -1e-9
    assert np.linalg.norm(positions - place, axis=1).min() > 0.05


def test_the_drawn_arm_is_stiff_and_ends_at_the_ball(calibrated):
    document = json.loads((calibrated / "calibration.json").read_text())
    arm = json.loads((calibrated / "report.json").read_text())["arm"]
    samples = [sample["position"] for row in document["data"] for sample in row["samples"]]
    robot = mukca.load_calibration(calibrated / "calibration.json").calibrated
    drawn = np.array(arm["calibrated"])
    assert np.allclose(drawn[:, -1], robot.ball(np.array(samples)), atol=1e-5)
    lengths = np.linalg.norm(np.diff(drawn, axis=1), axis=2)
    assert np.allclose(lengths, lengths[0], atol=3e-5)


SHAPES = """<link name="panda_link0"><visual><origin xyz="0 0 1"/><geometry>
  <box size="0.2 0.2 0.4"/></geometry></visual></link>"""
MESHES = """<link name="panda_link1"><visual><geometry><mesh filename="package://some/ball.stl"/>
  </geometry></visual><visual><geometry><mesh filename="http://localhost/x.stl"/></geometry>
  </visual></link>"""


def test_shapes_come_with_the_links_and_missing_ones_do_not_hurt(document, report, tmp_path):
    import trimesh

    trimesh.creation.icosphere(subdivisions=4, radius=0.1).export(tmp_path / "ball.stl")
    model = document["model"]
    model["source"] = str(tmp_path / "robot.urdf")
    plain = model["nominal_urdf"]
    for name, link in (("panda_link0", SHAPES), ("panda_link1", MESHES)):
        start = plain.index(f'<link name="{name}"')
        end = plain.index(">", start) + 1
        if plain[end - 2] != "/":
            end = plain.index("</link>", start) + len("</link>")
        plain = plain[:start] + link + plain[end:]
    model["nominal_urdf"] = plain
    arm = report(document)["arm"]
    assert [mesh["frame"] for mesh in arm["meshes"]] == [1, 2]
    box, ball = (np.array(mesh["vertices"]) for mesh in arm["meshes"])
    assert np.allclose(box.min(axis=0), [-0.1, -0.1, 0.8])
    assert np.allclose(box.max(axis=0), [0.1, 0.1, 1.2])
    assert np.linalg.norm(ball, axis=1) == pytest.approx(0.1, abs=0.02)
    faces = np.array(arm["meshes"][1]["faces"])
    assert 100 < len(faces) <= 600 and faces.max() < len(ball)
    assert len(arm["frames"]) == len(arm["calibrated"])


def test_large_sessions_are_drawn_in_part_and_counted_whole(document, report, tmp_path):
    rows = document["data"][1]["samples"]
    document["data"][1]["samples"] = [s for s in rows for _ in range(150)]
    figures = report(document)
    assert len(figures["samples"]) <= 3000
    assert figures["summary"]["test"]["samples"] == 24 * 150 + 24
    assert len(json.dumps(figures)) < 4_000_000
