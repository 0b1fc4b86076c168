"""The insertion in simulation: it is the model that decides, not the controller."""

import json

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="the extra simulation is not installed")

from mukca.tools.cli import main
from mukca.tools.commands.demo import demo_arm
from mukca.tools.experiments.controller import ArmModel
from mukca.tools.experiments.scene import urdf_of


def simulate(capsys, *words: str) -> dict:
    assert main(["simulate", "insertion", *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_calibrated_model_inserts_and_the_nominal_does_not(capsys) -> None:
    calibrated = simulate(capsys, "--model", "calibrated", "--trials", "4", "--cross", "2")
    assert calibrated["centre"]["inserted"] == 4
    assert calibrated["cross"]["inserted"] == 2
    true = simulate(capsys, "--model", "true", "--trials", "2")
    assert true["centre"]["inserted"] == 2
    nominal = simulate(capsys, "--model", "nominal", "--trials", "4")
    assert nominal["centre"]["inserted"] < 4
    error = [found["centre"]["tracking_error"] for found in (nominal, calibrated)]
    assert error[1] < 1e-3 < error[0]


def test_a_seed_repeats(capsys) -> None:
    twice = [simulate(capsys, "--trials", "1", "--seed", "3") for _ in range(2)]
    assert twice[0] == twice[1]


def test_the_model_is_the_arm_that_it_says() -> None:
    nominal, arm = demo_arm()
    q = np.array([0, -0.5, 0.2, -2.0, 0.1, 1.8, 0.3])
    poses = [
        ArmModel(text, arm.joint_names, arm.tip).pose(q).translation
        for text in (nominal.text.data, urdf_of(arm))
    ]
    assert 1e-3 < np.linalg.norm(poses[0] - poses[1]) < 5e-2


@pytest.mark.parametrize(
    "words", [("--hole-mm", "9"), ("--trials", "0"), ("--cross", "25"), ("--model", "nowhere.urdf")]
)
def test_bad_arguments_get_one_line(capsys, words: tuple[str, ...]) -> None:
    assert main(["simulate", "insertion", *words]) == 2
    error = capsys.readouterr().err
    assert len(error.strip().splitlines()) == 1
