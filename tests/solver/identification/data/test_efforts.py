"""Efforts are held against the gravity torque of the model's masses."""

import re

import numpy as np
import pytest
from altered import with_efforts
from recorded import RIGID

import mukca
from mukca.solver.identification.data import STANDARD_LOAD, Load, measure
from mukca.solver.identification.robot import gravity_moments

HANGING = Load((0.0, 0.0, 9.81), 0.0)


@pytest.fixture(scope="module")
def recorded():
    robot = mukca.load_robot("panda")
    _, (placement,) = mukca.simulate_recordings(robot, 1, seed=4, samples=12)
    return robot, placement


def measured(recorded, factor, load=STANDARD_LOAD):
    robot, placement = recorded
    tau = gravity_moments(robot, placement.positions)[:, :7]
    noise = np.random.default_rng(1).normal(0, 0.3, tau.shape)
    return measure(with_efforts(placement, factor * (tau + noise)), robot, load=load)


@pytest.mark.parametrize(
    ("factor", "load", "words"),
    [
        (-1.1, STANDARD_LOAD, r"efforts are -1\.1\d? times .*correlation -.*option `effort`"),
        (1.0, HANGING, r"efforts are -1 times .* does the arm hang \(--gravity\)"),
        (1000.0, STANDARD_LOAD, r"efforts are 1e\+03 times .* are they in N m"),
    ],
)
def test_efforts_of_another_sign_or_unit_are_left_out(recorded, factor, load, words):
    found = measured(recorded, factor, load)
    assert found.efforts is None
    assert any(re.search(words, line) for line in found.warnings), found.warnings


@pytest.mark.parametrize(("factor", "load"), [(1.0, STANDARD_LOAD), (-1.0, HANGING), (0.6, None)])
def test_efforts_that_agree_are_kept(recorded, factor, load):
    found = measured(recorded, factor, load)
    assert found.efforts is not None and not found.warnings


def test_efforts_that_have_nothing_to_do_with_gravity_are_kept(recorded):
    robot, placement = recorded
    efforts = np.random.default_rng(2).normal(0, 30, placement.positions.shape)
    found = measure(with_efforts(placement, efforts), robot, load=STANDARD_LOAD)
    assert found.efforts is not None


def test_a_model_without_masses_is_said(recorded, tmp_path):
    robot, placement = recorded
    text = re.sub(r"<inertial>.*?</inertial>", "", robot.text.data.decode(), flags=re.DOTALL)
    (tmp_path / "light.urdf").write_text(text)
    found = mukca.calibrate(mukca.load_robot(tmp_path / "light.urdf"), placement, **RIGID)
    assert sum("the URDF has no masses" in line for line in found.document.warnings) == 1
