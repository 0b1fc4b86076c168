"""What the nominal model tells the operator: gravity, and a ball that was elsewhere."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mukca.recorder import read_placement
from mukca.recorder.dataset import Sample
from mukca.solver.data import Load
from mukca.solver.robot import Robot, gravity_torques, load_robot
from mukca.tools.recording.outlier_checks import (
    OutlierCheck,
    gravity_of,
    similar_models,
    wrong_model_check,
)


def test_gravity_is_the_model_s(panda: Robot) -> None:
    gravity = gravity_of(panda)
    assert gravity is not None
    for q in np.random.default_rng(0).uniform(-1, 1, (3, 7)):
        expected = gravity_torques(panda, q[None])[0]
        assert gravity(q.tolist()) == pytest.approx(expected)


def test_gravity_is_the_load_s(panda: Robot) -> None:
    load = Load(gravity=(0.0, 9.81, 0.0), payload=0.5)
    gravity = gravity_of(panda, load)
    q = np.random.default_rng(0).uniform(-1, 1, 7)
    assert gravity is not None
    expected = gravity_torques(panda, q[None], load.gravity, load.payload)[0]
    assert gravity(q.tolist()) == pytest.approx(expected)


def test_a_model_without_masses_knows_no_gravity(panda: Robot) -> None:
    assert gravity_of(replace(panda, bodies=())) is None


def test_a_sample_of_the_other_socket_is_doubted_and_no_other(panda: Robot, session: Path) -> None:
    check = OutlierCheck(panda, 0.05)
    samples = read_placement(session / "front").samples
    taken: list[Sample] = []
    for number, sample in enumerate(samples, start=1):
        taken.append(replace(sample, number=number))
        assert check(taken) is None
    wrong = replace(samples[0], socket=1, number=99)
    assert "is it seated, and in socket 1?" in str(check([*taken, wrong]))


def test_few_samples_are_judged_by_less(panda: Robot, session: Path) -> None:
    first, *_, last = read_placement(session / "front").samples
    check = OutlierCheck(panda, 0.05)
    assert check([replace(first, number=1), replace(last, number=2)]) is None
    elsewhere = read_placement(session / "left").samples[0]
    told = str(check([replace(first, number=1), replace(elsewhere, number=3)]))
    assert "mm from the others of socket 0: is it seated, and in socket 0?" in told
    told = str(check([replace(first, number=1), replace(elsewhere, socket=1, number=4)]))
    assert "mm from the other socket" in told


def test_another_arm_is_known_by_how_it_moves(session: Path) -> None:
    check = wrong_model_check(load_robot("iiwa14"))
    taken = [replace(s, number=i) for i, s in enumerate(read_placement(session / "front").samples)]
    assert check(taken[:2]) is None and wrong_model_check(load_robot("panda"))(taken) is None
    assert "this moves like a panda" in str(check(taken[:3])).replace("fr3", "panda")


def test_another_arm_is_known_by_its_limits(session: Path) -> None:
    alike = similar_models(load_robot("iiwa14"))
    told = str(alike(read_placement(session / "front").samples[0].position))
    assert "panda" in told and "iiwa14" not in told
    assert alike((9.0,) * 7) is None
