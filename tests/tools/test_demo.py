"""The demo does the whole job, and finds the demo arm as it truly is."""

import json
import re
import signal
import subprocess
import sys
import time
from shutil import copytree

import numpy as np
import pytest

import mukca
from mukca.tools.cli import main
from mukca.tools.simulation import demo_arm

pytestmark = pytest.mark.slow


def test_the_nominal_demo_arm_is_off_by_what_real_arms_are(demo):
    summary = json.loads((demo / "calibrated/calibration.json").read_text())["summary"]
    assert 7e-3 < summary["left_out"]["nominal"]["mean_absolute_error"] < 9e-3
    assert summary["left_out"]["calibrated"]["mean_absolute_error"] < 1.5e-4


def test_the_calibrated_demo_arm_is_the_true_one(demo):
    """Distances between far ball positions agree with the truth; the base frame itself cannot."""
    calibration = mukca.load_calibration(demo / "calibrated/calibration.json").calibrated
    _, arm = demo_arm()
    truth = calibration.model.parameters_at(arm.origins)
    ready = np.array([0, 0.6, 0, -1.9, 0, 2.4, 0])
    q = ready + np.random.default_rng(0).uniform(-0.4, 0.4, (50, 7))
    true = calibration.model.points(truth, q)
    lengths = np.linalg.norm(true[1:] - true[:-1], axis=1)
    predicted = np.linalg.norm(np.diff(calibration.ball(q), axis=0), axis=1)
    nominal = np.linalg.norm(np.diff(calibration.nominal_ball(q), axis=0), axis=1)
    assert np.abs(predicted - lengths).mean() < 0.15 * np.abs(nominal - lengths).mean()


def test_the_demo_records_with_the_recorder(demo):
    for name in ("front", "left", "right"):
        taken, truth = (
            mukca.read_placements(demo / folder / name)[0] for folder in ("recordings", "hand")
        )
        assert np.abs(taken.positions - truth.positions).max() < 6 * 2e-5 / np.sqrt(75)
        assert taken.sockets.tolist() == truth.sockets.tolist() == ([0] * 6 + [1] * 6) * 5
        assert taken.efforts is not None


def test_the_demo_sums_its_recordings_up_and_leads_to_a_real_arm(demo):
    said = demo.with_suffix(".txt").read_text()
    assert said.count(": 30 in socket 0, 30 in socket 1\n") == 3
    assert "captured" not in said
    assert said.count("mock:") == 4  # in what was typed, and to lead a session oneself
    assert "mukca print-parts" in said.partition("Report: ")[2]
    was, now, file = said.splitlines()[-3:]
    summary = json.loads((demo / "calibrated/calibration.json").read_text())["summary"]["left_out"]
    before = summary.get("ball_refitted") or summary["nominal"]
    after = summary.get("geometric") or summary["calibrated"]
    assert was.startswith(f"It was: {1e3 * before['mean_absolute_error']:.2f} mm")
    assert now.startswith(f"It is:  {1e3 * after['mean_absolute_error']:.3f} mm")
    assert file.startswith("Open:") and file.endswith("calibrated/report.html")


def test_the_demo_never_removes_a_recording_of_a_real_arm(demo, tmp_path, capsys):
    left = copytree(demo / "recordings/left", tmp_path / "recordings/left")
    metadata = (left / "placement.json").read_text()
    (left / "placement.json").write_text(re.sub('"mock:[^"]*"', '"franka:1.2.3.4"', metadata))
    assert main(["demo", "--out", str(tmp_path), "--force"]) == 2
    assert "left: holds a recording of a real arm" in capsys.readouterr().err
    (left / "placement.json").write_text("{")
    assert main(["demo", "--out", str(tmp_path), "--force"]) == 2
    assert "placement.json: cannot be read as JSON" in capsys.readouterr().err
    assert (left / "samples.csv").read_bytes() == (
        demo / "recordings/left/samples.csv"
    ).read_bytes()


@pytest.mark.waits
def test_a_computer_that_is_busy_elsewhere_is_no_fault_of_the_demo_arm(tmp_path):
    words = [sys.executable, "-m", "mukca", "demo", "--out", "demo"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen(words, cwd=tmp_path, **pipes) as demo:
        lines = [demo.stdout.readline() for _ in range(3)]  # until its first session begins
        for _ in range(4):
            time.sleep(0.2)
            demo.send_signal(signal.SIGSTOP)
            time.sleep(0.6)  # longer than any pause of a stream that is alive
            demo.send_signal(signal.SIGCONT)
        lines.append(demo.stdout.readline())
        demo.kill()
    assert lines[1].startswith("$ mukca record") and "30 in socket 1" in lines[3], lines
