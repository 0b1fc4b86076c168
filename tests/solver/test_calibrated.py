"""What is written is what was found: read back, and by an independent library."""

import json
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from mukca.solver.calibrated import (
    FORMAT,
    Calibration,
    CalibrationError,
    load_calibration,
)
from mukca.solver.robot.parameters import choose_parameters
from mukca.solver.robot.urdf import load_robot, shipped_robots


def calibrated(name: str) -> Calibration:
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    nominal = robot.origins.ravel()[[p.index for p in parameters]]
    noise = np.random.default_rng(0).normal(0, 0.01, len(nominal))
    return Calibration(robot, parameters, nominal + noise)


@pytest.mark.parametrize("name", shipped_robots())
def test_pinocchio_predicts_the_same_ball_from_the_urdf(name: str, tmp_path: Path) -> None:
    calibration = calibrated(name)
    file = tmp_path / "calibrated.urdf"
    file.write_bytes(calibration.urdf(tmp_path))
    model = pinocchio.buildModelFromUrdf(str(file))
    data = model.createData()
    assert list(model.names)[1:] == list(calibration.robot.joint_names)
    for q in np.random.default_rng(1).uniform(-2, 2, (10, model.nq)):
        pinocchio.framesForwardKinematics(model, data, q)
        ball = data.oMf[model.getFrameId("ball_link")].translation
        assert calibration.ball(q) == pytest.approx(ball, abs=1e-9)
    assert model.lowerPositionLimit == pytest.approx([j.lower for j in calibration.robot.actuated])


def test_a_calibration_reads_back(tmp_path: Path) -> None:
    calibration = calibrated("panda")
    file = tmp_path / "calibration.json"
    file.write_text(json.dumps({"format": FORMAT, **calibration.as_dict()}))
    again = load_calibration(file)
    assert again.values.tolist() == calibration.values.tolist()
    assert again.parameters == calibration.parameters
    q = np.full(7, 0.3)
    assert again.ball(q).tolist() == calibration.ball(q).tolist()
    assert again.ball(np.stack([q, q])).shape == (2, 3)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "not a calibration.json"),
        ("[]", "not a calibration.json"),
        ('{"format": "other"}', "this version"),
        (json.dumps({"format": FORMAT}), "damaged"),
        (json.dumps({"format": FORMAT, "model": {}, "parameters": []}), "damaged"),
    ],
)
def test_a_bad_file_is_told(tmp_path: Path, text: str, told: str) -> None:
    file = tmp_path / "calibration.json"
    file.write_text(text)
    with pytest.raises(CalibrationError, match=told):
        load_calibration(file)


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(CalibrationError, match="No such file"):
        load_calibration(tmp_path / "none.json")
