"""What the nominal model tells the operator: gravity, and a ball that was elsewhere."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mukca.recorder.dataset import Sample, read_placement
from mukca.solver.data.observations import Load
from mukca.solver.robot.kinematics import gravity_torques
from mukca.solver.robot.urdf import Robot
from mukca.tools.hints import gravity_of, seat_check


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
    check = seat_check(panda)
    samples = read_placement(session / "front").samples
    taken: list[Sample] = []
    for number, sample in enumerate(samples, start=1):
        taken.append(replace(sample, number=number))
        assert check(taken) is None
    wrong = replace(samples[0], socket=1, number=99)
    assert "sample 99 puts the ball" in str(check([*taken, wrong]))
    assert "socket 1: is it seated" in str(check([*taken, wrong]))


def test_few_samples_cannot_be_judged(panda: Robot, session: Path) -> None:
    first, *_, last = read_placement(session / "front").samples
    two = [replace(first, number=1), replace(last, socket=0, number=2)]
    assert seat_check(panda)(two) is None
