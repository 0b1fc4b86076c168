"""A tool's tip found with the calibrated chain held."""

import html
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from altered import write_rows, write_samples
from recorded import recorded_in_reach, true_arm
from worlds import TRANSLATION, TURN, realistic_flaws

import mukca
from mukca import MukcaError

pytestmark = pytest.mark.slow

TIP, SHAFT = np.array([0.03, -0.02, 0.2]), np.array([0.03, -0.02, 0.15])


def test_the_tip_stays_at_points_elsewhere_as_closely_as_is_predicted(simulated):
    found = mukca.tool(simulated.calibration, simulated.touched(TIP), "spike")
    elsewhere = simulated.touched(TIP, 12, seed=5).positions
    held = found.calibration.flange(elsewhere, tool="spike")[:, :3, 3]
    scatter = float(np.mean(np.sum((held - held.mean(axis=0)) ** 2, axis=1))) ** 0.5
    assert scatter < 3 * found.elsewhere < 1.5e-3
    assert b'link name="spike"' in found.calibration.urdf()
    assert repr(found).startswith("spike on panda_") and "Touches scatter" in repr(found)


def test_a_bad_touch_weighs_little(simulated):
    touched = simulated.touched(TIP)
    q = touched.positions.copy()
    q[3, 3] += 0.02
    bad = mukca.Placement.of_arrays("bad", q, [0] * len(q))
    sound, found = (mukca.tool(simulated.calibration, one) for one in (touched, bad))
    assert found.residuals.argmax() == 3 and found.residuals[3] > 3e-3
    assert len(found.outliers) == 1 and found.outliers[0].startswith("touch 3: ")
    assert found.outliers[0] in found.text and not sound.outliers
    assert np.array(found.frame.xyz) == pytest.approx(np.array(sound.frame.xyz), abs=1e-3)


def test_joints_that_scatter_alike_are_no_zero_that_changed(simulated):
    q = simulated.touched(TIP, 16).positions
    q = q + np.random.default_rng(1).normal(0, 3e-3, q.shape)
    found = mukca.tool(simulated.calibration, mukca.Placement.of_arrays("t", q, [0] * len(q)))
    assert "All joints scatter alike, by some 3 mrad" in found.untold[0]


@pytest.mark.parametrize("joint", [1, 3, 5])
def test_a_zero_that_changed_since_is_told(simulated, joint):
    touched = simulated.touched(TIP)
    q = touched.positions - 5e-3 * np.eye(7)[joint]
    found = mukca.tool(simulated.calibration, mukca.Placement.of_arrays("t", q, [0] * len(q)))
    assert "A joint's zero changed since the calibration" in found.untold[0]
    assert "mukca rezero" in found.untold[0]
    sound = mukca.tool(simulated.calibration, touched)
    assert not sound.untold
    assert np.trace(found.frame.covariance) > 4 * np.trace(sound.frame.covariance)


def test_a_tip_less_sure_than_a_limit_is_not_enough(simulated, cal, tmp_path, command, refused):
    words = ("tool", cal, written(tmp_path / "t.csv", simulated.touched(TIP)))
    status, out, _ = command(*words, "--limit-mm", "0.001")
    assert status == 3 and "NOT ENOUGH DATA: these touches cannot show the tip along" in out
    refused("--limit-mm 0: give millimetres above 0", *words, "--limit-mm", "0")


def test_samples_of_the_calibration_itself_are_told(simulated):
    (front, *_) = simulated.calibration.document.data
    own = front.placement(simulated.calibration.robot.joint_names)
    found = mukca.tool(simulated.calibration, own)
    assert "trained on these samples, so the tip is its ball" in found.untold[0]


def test_points_of_which_it_is_known_how_they_lie_tell_more(simulated):
    """Two points, 0.1 m apart where nobody says so, and where it is said."""
    touched = simulated.touched_at_two(TIP, 0.1)
    free = replace(touched, distance=None)
    at = [(0.0, 0.1 * s.socket, 0.0) for s in touched.samples]
    samples = [replace(s, socket=0, point=p) for s, p in zip(touched.samples, at, strict=True)]
    known = replace(free, samples=tuple(samples))
    one, two = (mukca.tool(simulated.calibration, p) for p in (free, known))
    assert two.elsewhere <= one.elsewhere < 5e-4
    assert np.array(two.frame.xyz) == pytest.approx(np.array(one.frame.xyz), abs=1e-3)


def test_what_tells_too_little_is_said(simulated):
    """Postures alike, one point for a direction, and three touches."""
    touches = simulated.touched(TIP)
    q = touches.positions[:1] + np.linspace(0, 2e-4, 6)[:, None]
    found = mukca.tool(simulated.calibration, mukca.Placement.of_arrays("alike", q, [0] * 6))
    assert "turn the tool about two more axes" in found.text[0]
    with pytest.raises(MukcaError, match="tells no direction"):
        mukca.tool(simulated.calibration, touches, "spike", axis=touches)
    with pytest.raises(MukcaError, match="3 touches; a tip needs 4"):
        mukca.tool(simulated.calibration, simulated.touched(TIP, 3))


def written(file, touches):
    """Write touches as a CSV file of joint positions."""
    return write_rows(file, touches.positions.tolist(), touches.joint_names)


def test_the_command_takes_a_shaft_a_face_and_sockets_that_stood(
    simulated, cal, tmp_path, command, refused
):
    aside = 0.03 * np.eye(3)
    points = {"tip": TIP, "shaft": SHAFT, "x": TIP + aside[0], "y": TIP + aside[1]}
    tip, shaft, x, y = (
        written(tmp_path / f"{name}.csv", simulated.touched(point, seed=i))
        for i, (name, point) in enumerate(points.items())
    )
    words = ("tool", cal, tip, "--json")
    z = {"axis": ("--axis", shaft), "face": ("--face", x, y)}
    for name, more in z.items():
        status, out, _ = command(*words, *more, "--out", tmp_path / name)
        assert status == 0, out
        found = mukca.load_calibration(tmp_path / name).kinematics(tool="tool").tool
        assert found[:3, 2] == pytest.approx([0, 0, 1], abs=0.05)
        assert name == "axis" or found[:3, 0] == pytest.approx([1, 0, 0], abs=0.05)
    base = simulated.first_base
    few = written(tmp_path / "few.csv", simulated.touched(TIP, 4, seed=1, base=base))
    known, free = (
        json.loads(command("tool", cal, few, "--json", *more)[1])
        for more in (("--stood", base.name), ())
    )
    assert known["xyz"][:2] == pytest.approx(TIP[:2].tolist(), abs=5e-4)
    assert np.trace(known["covariance"]) < 0.5 * np.trace(free["covariance"])
    refused("kitchen", *words, "--stood", "kitchen")


def test_the_command_takes_a_csv_file(simulated, cal, tmp_path, command, refused):
    written(tmp_path / "spike.csv", simulated.touched(TIP))
    words = ("tool", cal, tmp_path / "spike.csv", "--name", "spike", "--json")
    status, out, told = command(*words, "--out", tmp_path / "new")
    said = json.loads(out)
    assert status == 0 and said["elsewhere"] < 5e-4
    page = html.unescape(Path(said["outputs"]["report"]).read_text())
    assert all(line in page for line in told.partition("--details")[0].splitlines())
    robot = mukca.load_robot(said["outputs"]["urdf"])
    assert "spike" in robot.text.links
    write_samples(tmp_path / "front", simulated.touched(TIP))
    status, out, _ = command(*words[:2], tmp_path / "front" / "samples.csv", "--json")
    assert status == 0 and json.loads(out)["xyz"] == pytest.approx(said["xyz"])
    refused("nothere.csv: no such file\n", *words[:2], tmp_path / "nothere.csv")
    refused("'my tool': a link's name has no blanks", *words[:3], "--name", "my tool")
    refused("tells no direction", *words[:3], "--axis", tmp_path / "spike.csv")


def test_an_arm_whose_samples_leave_open_if_lengths_or_angles_are_wrong_is_held_loosely():
    robot, generator = mukca.load_robot("ur5e"), np.random.default_rng([7, 12])
    arm = true_arm(robot, generator, TRANSLATION, TURN)
    how = realistic_flaws(robot, generator)
    train = recorded_in_reach(arm, generator, 2, imperfection=how)
    calibration = mukca.calibrate(robot, train)
    found, truth = (
        calibration.document.parameters,
        calibration.calibrated.model.parameters_at(arm.origins),
    )
    off = [(p.calibrated - t, p.standard_deviation) for p, t in zip(found, truth, strict=True)]
    assert max(abs(one) / deviation for one, deviation in off if deviation) < 6
