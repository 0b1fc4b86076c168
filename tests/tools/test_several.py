"""Several robots on the command line: whose placements, what is written, what is wrong."""

import json
import shlex

import numpy as np
import pytest
from calibrated_arm import recorded_face_to_face
from recorded import true_arm, write_sockets

import mukca
from mukca import load_robot

pytestmark = pytest.mark.slow

ROBOTS = ["--robot", "left=panda", "--robot", "right=ur5e", "--without", "compliance", "tilt"]
ROBOTS += ["transmission", "joint-noise"]


@pytest.fixture(scope="module")
def cell(true_panda, shared):
    """Two arms face to face, and two bases that both visited."""

    def make(folder):
        generator = np.random.default_rng(11)
        recorded = recorded_face_to_face(two_arms(true_panda), generator, noise=1e-4)
        written_by_arm(recorded, folder)

    return shared("cell", make)


def two_arms(true_panda):
    """The true arms of the cell."""
    return [true_panda, true_arm(load_robot("ur5e"), np.random.default_rng(5))]


def written_by_arm(recorded, folder):
    """Write what each arm recorded to its folder."""
    for name, placements in zip(("left", "right"), recorded, strict=True):
        for placement in placements:
            write_sockets(folder / name / placement.name, placement)


def test_two_arms_are_written_each_and_together(cell, true_panda, tmp_path, command, refused):
    for name in ("left", "right"):  # one by its own word, the other by the command's
        for folder in (cell / name).iterdir():
            text = json.dumps({"robot_name": "right"} if name == "right" else {})
            (folder / "placement.json").write_text(text)
    out = tmp_path / "out"
    words = (f"left:{cell / 'left'}", cell / "right", *ROBOTS, "--out", out, "--json")
    _, text, told = command("solve", *words)
    result = json.loads(text)
    pose = result["left_to_right"]
    assert pose["xyz"] == pytest.approx([1.2, 0, 0], abs=0.05)
    assert pose["shared_sockets"] == 4 and 5e-5 < pose["tool_deviation"] < 1e-3
    assert [row["robot"] for row in result["placements"]] == ["left", "left", "right", "right"]
    assert set(result["robots"]) == {"left", "right"}
    assert "Tool to tool" in pose["text"] and "joint 1 zero" in told
    files = {str(file.relative_to(out)) for file in out.rglob("*") if file.is_file()}
    assert {"arms.urdf", "arms.json", "left/calibrated.urdf", "right/calibration.json"} <= files
    right = mukca.load_robot(out / "arms.urdf", tip="right_ball_link")
    assert right.base == "world" and len(right.actuated) == 6
    report, page = ((out / "right" / f"report.{kind}").read_text() for kind in ("json", "html"))
    assert page.count("arm model-0") == page.count("arm model-1") == 4  # two views of two bases
    assert "<ellipse" in page and pose["text"] in page
    steps = [step["command"] for step in json.loads(report)["todo"]]
    records = [command for command in steps if command.startswith("mukca record")]
    assert all("--robot ur5e" in one and "--robot-name right" in one for one in records)
    again = shlex.split(json.loads(report)["command"])
    assert json.loads(command(*again[1:], "--json")[1])["left_to_right"]["xyz"] == pose["xyz"]
    used_again(out, cell, command)
    tools_meet(out, tmp_path / "again", true_panda, command, refused)
    trained = (f"left:{cell / 'left'}", f"right:{cell / 'right'}", "--tool-to-tool")
    status, _, told = command("validate", out, *trained)
    assert status == 2 and told.count("trained on, so left out") == 4
    assert "placements that the calibration was not trained on, of two arms" in told
    refused("calibrated together", "validate", out / "left", cell / "left", "--tool-to-tool")
    words = ("validate", out, *trained, "--distance", "0.05")
    refused("--tool-to-tool and --distance: give one of the two", *words)
    for file in (".", "sheet", "sheet.doc"):
        refused(f"--certificate {file}: end its name in .pdf", "report", out, "--certificate", file)
    sheet = ("--certificate", tmp_path / "sheet.html")
    command("report", out, *sheet)
    assert all((tmp_path / f"sheet_{arm}.html").exists() for arm in ("left", "right"))
    for verb in ("poses", "rezero", "tool", "handeye --camera on-arm"):
        refused(f"name one of {out / 'left'}, {out / 'right'}", *verb.split(), out, "q.csv")


def test_arms_that_shared_one_base_are_written_without_where_they_stand(cell, tmp_path, command):
    """It is said why, and what cures it."""
    own = [f"{name}:{cell / name / 'front'}" for name in ("left", "right")]
    out = tmp_path / "out"
    _, text, told = command("solve", *own, *ROBOTS, "--out", out, "--json")
    assert json.loads(text)["left_to_right"]["xyz"] is None
    assert "two sockets shared leave it free to turn about their line" in told
    assert "two placements cure it, three are better" in told
    assert f"Wrote {out / 'arms.json'}, and a folder for each robot" in told
    assert not (out / "arms.urdf").exists() and (out / "right" / "report.html").is_file()
    arms = mukca.load_calibration(out)
    assert [bool(arm.postures) for arm in arms.document.arms] == [True, False]
    for refused in (lambda: arms.pose("right"), arms.urdf):
        with pytest.raises(mukca.MukcaError, match="free to turn"):
            refused()


def tools_meet(out, later, true_panda, command, refused):
    """Where both arms have the ball in one socket, their tools are predicted at one place."""
    arms, generator = two_arms(true_panda), np.random.default_rng(12)
    recorded = recorded_face_to_face(arms, generator, samples=4, noise=1e-4)
    written_by_arm(recorded, later)
    words = (out, f"left:{later / 'left'}", f"right:{later / 'right'}", "--tool-to-tool", "--json")
    status, text, told = command("validate", *words, "--limit-mm", "1")
    (row,) = json.loads(text)["tool_to_tool"]
    assert status == 0 and row["samples"] == [16, 16] and row["pairs"] == 64
    assert "PASS: 95 % of the distances" in told
    calibration, errors = mukca.load_calibration(out), []
    left, right = recorded
    for a, b in zip(left, right, strict=True):
        balls = calibration["left"].ball(a.positions)
        others = calibration.pose("right").apply(calibration["right"].ball(b.positions))
        errors += [
            np.linalg.norm(balls[i] - others[k])
            for i, socket in enumerate(a.sockets)
            for k in np.flatnonzero(b.sockets == socket)
        ]
    spread = row["calibrated"]
    assert [spread["mean"], spread["max"]] == pytest.approx([np.mean(errors), max(errors)])
    assert spread["mean"] < spread["p95"] < spread["max"] < 1e-3
    status, _, told = command("validate", *words, "--limit-mm", "0.05")
    assert status == 1 and "FAIL: 95 %" in told and "swapped" not in told
    told = f"look swapped; type left:{later / 'left'} right:{later / 'right'}"
    swapped = (f"left:{later / 'right'}", f"right:{later / 'left'}", "--tool-to-tool")
    refused(told, "validate", out, *swapped)


def used_again(out, cell, command):
    """What was written of both is read back by all that reads calibrations."""
    (out / "arms.json").write_text((out / "arms.json").read_text().replace('"format"', '"older"'))
    arms = mukca.load_calibration(out)
    left, right = arms["left"], arms["right"]
    q, at = [0.1, -0.4, 0.2, -2.0, 0.1, 1.7, 0.8], [0.3, -1.2, 1.5, -1.0, 1.2, 0.4]
    apart = np.linalg.inv(arms.pose("right").matrix @ right.flange(at)) @ left.flange(q)
    there = {"frame": "right/flange", "at": at}
    assert np.abs(left.flange(q, **there) - apart).max() < 1e-12
    assert np.abs(left.flange(left.command(apart, q, **there)) - left.flange(q)).max() < 1e-9
    stand = np.array([[0, -1, 0, 0.3], [1, 0, 0, 0.2], [0, 0, 1, -0.1], [0, 0, 0, 1.0]])
    there["base"] = stand
    assert np.abs(left.flange(q, **there) - stand @ apart).max() < 1e-12
    assert (
        np.abs(left.flange(left.command(stand @ apart, q, **there)) - left.flange(q)).max() < 1e-9
    )
    for frame, said in (("right/flange", "say by `at`"), ("middle", "left, left/flange, right,")):
        with pytest.raises(mukca.MukcaError, match=said):
            left.flange(q, frame=frame)
    places = [f"{name}:{cell / name / 'front'}" for name in ("left", "right")]
    for verb, *words in (
        ("validate", *places),
        ("report", "--out", out / "again-1.0"),
        ("export", "--to", "urdf", "--out", out / "arm.urdf"),
        ("export", "--to", "urdf", "--out", out / "exported-1.0"),
    ):
        status, text, _ = command(verb, out / "arms.json", *words, "--json")
        assert status in (0, 1, 3) and set(json.loads(text)["robots"]) == {"left", "right"}
    for file in ("again-1.0/right/report.html", "arm_left.urdf", "exported-1.0/left"):
        assert (out / file).is_file(), file
    (front,) = mukca.read_placements(cell / "right" / "front")
    q, sockets = front.positions - 5e-3 * np.eye(6)[2], front.sockets.tolist()
    since = mukca.Placement.of_arrays("since", q, sockets, distance=front.distance)
    found = mukca.rezero(right, since, stood="front")
    assert [one.joint for one in found.changed] == ["elbow_joint"]
    assert found.changed[0].offset == pytest.approx(5e-3, abs=5e-4)
    touched = mukca.Placement.of_arrays("touched", front.positions[:8], sockets[:8])
    ball = mukca.tool(right, touched).frame.xyz
    assert right.flange(at) @ [*ball, 1] == pytest.approx([*right.ball([at])[0], 1], abs=0.01)
    with pytest.raises(mukca.MukcaError, match="of several pick one"):
        mukca.rezero(arms, since)


def test_two_arms_of_one_type_need_no_extension_and_may_be_swapped(tmp_path, command, refused):
    """Those that do hardly anything have one name in both arms, and are left out of each."""
    generator = np.random.default_rng(3)
    arms = [true_arm(load_robot("panda"), generator) for _ in range(2)]
    recorded = recorded_face_to_face(arms, generator, samples=12, noise=1e-4)
    robots = {name: load_robot("panda") for name in ("left", "right")}
    found = mukca.calibrate(robots, dict(zip(robots, recorded, strict=True)), distance=0.05)
    assert set(found) == set(robots)
    found.save(tmp_path / "out")
    written_by_arm(recorded, tmp_path)
    left, right = tmp_path / "left", tmp_path / "right"
    words = ("validate", tmp_path / "out", "--tool-to-tool")
    _, told, _ = command(*words, f"left:{right}", f"right:{left}")
    assert "look swapped: exchanged, 95 % are right within 0." in told
    assert told.endswith(f"type left:{left} right:{right}\n")
    refused("are the same placement", *words, f"left:{left}", f"right:{left}")


def test_the_samples_of_one_arm_are_not_those_of_another(cell, refused):
    left = cell / "left"
    two = ("--robot", "left=panda", "--robot", "right=panda")
    refused("are the same placement", "solve", f"left:{left}", f"right:{left}", *two)
