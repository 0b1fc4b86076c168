"""What is written is what was found: read back, and by an independent library."""

import re

import numpy as np
import pinocchio
import pytest

from mukca import MukcaError
from mukca.solver.results import CalibratedRobot
from mukca.solver.robot import choose_parameters, load_robot, shipped_robots


def calibrated(name):
    robot = load_robot(name)
    parameters = choose_parameters(robot)
    nominal = robot.origins.ravel()[[p.index for p in parameters]]
    noise = np.random.default_rng(0).normal(0, 0.01, len(nominal))
    return CalibratedRobot(robot, parameters, nominal + noise)


@pytest.mark.parametrize("name", shipped_robots())
def test_pinocchio_predicts_the_same_ball_from_the_urdf(name, tmp_path):
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


def test_one_configuration_or_many(tmp_path):
    robot = calibrated("panda")
    q = np.full(7, 0.3)
    assert robot.ball(np.stack([q, q])).shape == (2, 3)
    assert robot.ball(q.tolist()) == pytest.approx(robot.ball(np.stack([q, q]))[1])


@pytest.mark.parametrize(
    ("q", "words"),
    [
        (np.zeros(6), "shape (6,): panda has 7 joints"),
        (np.zeros((2, 2, 7)), "shape (2, 2, 7): panda has 7 joints"),
        ([0, 0, 0, np.nan, 0, 0, 0], "row 0, 'panda_joint4' is nan"),
    ],
)
def test_joint_positions_of_another_robot_are_refused(q, words):
    for model in ("ball", "geometric_ball", "nominal_ball"):
        with pytest.raises(MukcaError, match=re.escape(words)):
            getattr(calibrated("panda"), model)(q)
