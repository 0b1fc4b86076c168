"""What is recorded of an emulated arm, and what the verbs that hold a calibration say of it."""

import html
from dataclasses import replace

import numpy as np
import pytest
from altered import write_rows

import mukca
from mukca.tools.cli import main
from mukca.tools.recording import ZeroSelector

pytestmark = pytest.mark.slow

TIP = np.array([0.03, -0.02, 0.2])


def test_poses_are_led_to_that_tell_the_zeros_best(simulated):
    taken = simulated.later.samples
    selector = ZeroSelector(simulated.calibration, 0.05, target=6)
    led, random = [], []
    for start in range(5):
        before, after = taken[start : start + 3], taken[start + 3 : start + 6]
        target = selector.advise(before, 0).target
        then = selector.advise([*before, replace(after[0], position=target)], 0)
        led.append(then.predicted)
        others = [selector.advise([*before, sample], 0).predicted for sample in after]
        random.append(np.median(others))
    assert np.log(led).mean() < np.log(random).mean() and then.goal < 1.5e-4
    end = selector.advise([*taken[:6], *taken[8:14]], 1)
    assert end.enough and end.target is None and end.predicted > 1.1 * then.goal


def test_sessions_of_an_emulated_arm_find_a_zero_and_a_tip(
    simulated, cal, tmp_path, scripted, capsys
):
    def recorded(name, rows, keys, *more, status=0, said=""):
        hand = write_rows(tmp_path / f"{name}.csv", rows.tolist())
        words = ["--distance", "0.05", "--no-guide", *more]
        done = scripted(tmp_path / name, keys, *words, hand=hand)
        assert done.status == status and said in done.output, done.errors
        return tmp_path / name

    rezero = f"mukca rezero {cal} {tmp_path / 'since'}"
    since = recorded(
        "since",
        simulated.read({3: 5e-3}).positions,
        "a*8 s a*8 q",
        "--calibration",
        str(cal),
        status=1,
        said=f"{rezero} --joint panda_joint4",
    )
    assert main(["check", str(since), "--calibration", str(cal)]) == 1
    assert f"{rezero} --joint panda_joint4" in capsys.readouterr().out
    assert main(["validate", str(cal), str(since)]) == 1
    new = tmp_path / "new"
    words = ["rezero", str(cal), str(since), "--out", str(new), "--details"]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "panda_joint4: +0.00" in said and "homing_offset -3 (Feetech), +3 (Dynamixel)" in said
    told = html.unescape((new / "report.html").read_text())
    assert next(line for line in said.splitlines() if "panda_joint4: +" in line) in told
    assert main(["check", str(since), "--calibration", str(new)]) == 0
    spike = recorded("spike", simulated.touched(TIP, 8).positions, "a*8 q")
    words = ["tool", str(cal), str(spike), "--out", str(tmp_path / "tip")]
    assert main(words) == 0
    found = mukca.load_calibration(tmp_path / "tip").document.tools[-1]
    assert np.array(found.xyz[:2]) == pytest.approx(TIP[:2], abs=1e-3)


def test_a_session_ends_with_the_words_of_validate(simulated, cal, tmp_path, scripted, capsys):
    """Here the ball lay in the other socket for a sample."""
    hand = write_rows(tmp_path / "hand.csv", simulated.read({}).positions.tolist())
    out = tmp_path / "since"
    words = ["--distance", "0.05", "--no-guide", "--calibration", str(cal)]
    done = scripted(out, "a*7 s a*9 q", *words, hand=hand)
    assert main(["validate", str(cal), str(out)]) == done.status == 0
    verdict = next(line for line in done.output.splitlines() if line.startswith("Verdict: "))
    assert verdict in capsys.readouterr().out.splitlines()
    assert "sample 8 lies in socket 0" in done.errors
    assert main(["validate", str(cal), str(out), "--as-recorded"]) == 1
    said = capsys.readouterr().out
    assert "errors of" in said and "within its limits" not in said
