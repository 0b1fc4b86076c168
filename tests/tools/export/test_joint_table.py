"""Joint tables: all their files are one table, which keeps what it says it keeps."""

import csv
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from imagined import configurations, edited

import mukca

EXAMPLE = Path(__file__).parents[3] / "examples" / "ros2_control"
STAND_IN = Path(__file__).with_name("ros2_control_stand_in")
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")


def waved(document):
    """Give each joint a smooth error curve, and let it bend under its load."""
    knots = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    curves = [1e-3 * np.sin(9 * knots + joint) for joint in range(6)]
    document["deflection"] = {
        "compliance": [2e-6] * 6,
        "curve": np.transpose(curves).ravel().tolist(),
    }


@pytest.fixture(scope="module")
def arm(calibrations, tmp_path_factory):
    """A UR5e whose joints wave, and the folder with its table, called arm."""
    folder = tmp_path_factory.mktemp("table")
    file = edited(calibrations / "ur5e.json", folder / "waved.json", waved)
    calibration = mukca.load_calibration(file)
    exported = mukca.export(calibration, "joint-table", folder / "arm.csv")
    return calibration, exported, folder


def table_of(folder):
    """Angles and offsets of each joint, as the CSV has them."""
    lines = (folder / "arm.csv").read_text().splitlines()
    table = {}
    for row in csv.DictReader(line for line in lines if not line.startswith("#")):
        numbers = [float(row[key]) for key in ("angle", "offset", "gravity")]
        table.setdefault(row["joint"], []).append(numbers)
    return {joint: np.transpose(rows) for joint, rows in table.items()}


def positions_by(table, readings):
    """Where the joints stand, by the CSV's offsets."""
    q = readings
    for _ in range(8):
        offsets = [
            np.interp(q[:, i], angles, row) for i, (angles, row, _) in enumerate(table.values())
        ]
        q = readings - np.transpose(offsets)
    return q


def test_urdf_and_offsets_keep_the_error_that_is_said(arm):
    calibration, exported, folder = arm
    (loss,) = exported.losses
    table = table_of(folder)
    p = np.array([s.position for s in calibration.document.data[0].samples])
    robot = mukca.load_robot(folder / "arm.urdf", tip=calibration.robot.tip)
    assert tuple(table) == robot.joint_names
    q = positions_by(table, p)
    balls = mukca.solver.results.CalibratedRobot(robot).ball(q)
    truths = calibration.calibrated.ball(p)
    within = [np.linalg.norm(b[:, None] - b[None], axis=2) for b in (balls, truths)]
    assert np.abs(within[0] - within[1]).max() <= 2 * loss.largest + 1e-9
    alone = calibration.calibrated.geometric_ball(p)
    without = np.linalg.norm(alone[:, None] - alone[None], axis=2)
    kept, lost = (np.abs(w - within[1]).mean() for w in (within[0], without))
    assert 0 < loss.mean < 1e-4 and kept < 0.1 * lost


def test_offsets_of_another_load_differ_by_what_gravity_adds(arm, tmp_path):
    calibration, _, folder = arm
    mukca.export(calibration, "joint-table", tmp_path / "arm.csv", payload=(3.0, (0, 0, 0)))
    light, heavy = table_of(folder), table_of(tmp_path)
    first, second = light["shoulder_pan_joint"], light["shoulder_lift_joint"]
    assert np.abs(first[2]).max() < 1e-9 < 1e-5 < np.abs(second[2]).max()
    rows = heavy["shoulder_lift_joint"][2]
    assert np.abs(rows).mean() > 1.05 * np.abs(second[2]).mean()
    assert "with 3 kg beyond" in (tmp_path / "arm.csv").read_text()


def test_yaml_and_header_have_the_same_numbers(arm):
    _, _, folder = arm
    table = table_of(folder)
    joints = yaml.safe_load((folder / "arm.yaml").read_text())["joints"]
    header = (folder / "arm.h").read_text()
    rows = re.findall(r"^  \{ (.*) \},$", header, re.M)
    for (joint, (angles, offsets, gravity)), row in zip(table.items(), rows, strict=True):
        said = joints[joint]
        assert said["offset"] == offsets.tolist() and said["gravity"] == gravity.tolist()
        last = said["first"] + said["step"] * (len(offsets) - 1)
        assert abs(said["first"] - angles[0]) + abs(last - angles[-1]) < 1e-9
        assert [float(word) for word in row.split(",")] == offsets.tolist()


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler")
def test_the_controller_adds_the_offsets_and_takes_them_off(arm, tmp_path):
    """By stand-ins for the headers of ros2_control: at any reference the arm stands there."""
    calibration, _, folder = arm
    table, program = table_of(folder), tmp_path / "controller"
    words = ["-std=c++17", *STRICT, f"-I{folder}", f"-I{STAND_IN}"]
    words += [EXAMPLE / "joint_table_controller.cpp", STAND_IN / "main.cpp", "-o", program]
    done = subprocess.run(["c++", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    q = configurations(calibration.robot, 40, seed=1)
    lines = "\n".join(" ".join(map(repr, row)) for row in q.tolist())
    shown = subprocess.run([program], input=lines, capture_output=True, text=True, check=True)
    first, *rows = [line.split() for line in shown.stdout.splitlines()]
    assert first == [f"table/{joint}/position" for joint in table]
    commanded, states = np.array(rows, dtype=float).reshape(len(q), 2, 6).swapaxes(0, 1)
    assert np.abs(positions_by(table, commanded) - q).max() < 1e-9
    assert np.abs(states - q).max() < 1e-9 < 1e-5 < np.abs(commanded - q).max()
