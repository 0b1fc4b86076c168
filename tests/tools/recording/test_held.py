"""What is recorded of an emulated arm, and what the verbs that hold a calibration say of it."""

import html

import numpy as np
import pytest
from calibrated_arm import simulate

import mukca
from mukca.tools.cli import main

TIP = np.array([0.03, -0.02, 0.2])


@pytest.mark.slow
def test_sessions_of_an_emulated_arm_find_a_zero_and_a_tip(tmp_path, scripted, capsys):
    simulated = simulate()

    def recorded(name, rows, keys):
        hand = tmp_path / f"{name}.csv"
        hand.write_text("\n".join(",".join(map(str, row)) for row in rows.tolist()))
        done = scripted(tmp_path / name, keys, "--distance", "0.05", "--no-guide", hand=hand)
        assert done.status == 0, done.errors
        return tmp_path / name

    simulated.calibration.save(tmp_path / "cal")
    since = recorded("since", simulated.read({3: 5e-3}).positions, "a*8 s a*8 q")
    assert main(["check", str(since), "--calibration", str(tmp_path / "cal")]) == 1
    assert "mukca rezero --joint panda_joint4" in capsys.readouterr().out
    assert main(["validate", str(tmp_path / "cal"), str(since)]) == 1
    new = tmp_path / "new"
    assert main(["rezero", str(tmp_path / "cal"), str(since), "--out", str(new)]) == 0
    said = capsys.readouterr().out
    assert "panda_joint4: +0.00" in said and "homing_offset -3 (Feetech), +3 (Dynamixel)" in said
    told = html.unescape((new / "report.html").read_text())
    assert next(line for line in said.splitlines() if "panda_joint4: +" in line) in told
    assert main(["check", str(since), "--calibration", str(new)]) == 0
    spike = recorded("spike", simulated.touched(TIP, 8).positions, "a*8 q")
    words = ["tool", str(tmp_path / "cal"), str(spike), "--out", str(tmp_path / "tip")]
    assert main(words) == 0
    found = mukca.load_calibration(tmp_path / "tip").document.tools[-1]
    assert np.array(found.xyz[:2]) == pytest.approx(TIP[:2], abs=1e-3)
