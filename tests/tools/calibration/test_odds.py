"""Ten poses against a calibration: the same arm is valid, a shifted joint is found."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mukca
from mukca.recorder.dataset import Placement, read_placement
from mukca.solver.data.measurements import measure
from mukca.solver.robot.urdf import Robot
from mukca.tools.calibration.calibration import Calibration
from mukca.tools.calibration.odds import Odds, odds_of
from mukca.tools.recording.beside import goal_for

Ask = Callable[[int, float], Odds]


@pytest.fixture(scope="module")
def calibration(panda: Robot, session: Path) -> Calibration:
    train, test = (read_placement(session / name) for name in ("front", "left"))
    return mukca.calibrate(panda, train, test=test, method="paper")


def ten(placement: Placement, joint: int = 0, offset: float = 0.0) -> Placement:
    """The first ten poses of socket 0, a joint's zero shifted."""
    shift = np.zeros(placement.positions.shape[1])
    shift[joint] = offset
    poses = [s for s in placement.samples if s.socket == 0][:10]
    moved = [replace(s, position=tuple((np.array(s.position) + shift).tolist())) for s in poses]
    return replace(placement, samples=tuple(moved))


@pytest.fixture(scope="module")
def ask(calibration: Calibration, session: Path) -> Ask:
    later = read_placement(session / "right")
    summary = calibration.document.summary.test
    assert summary

    def ask(joint: int, offset: float) -> Odds:
        measured = measure(ten(later, joint, offset), calibration.robot, sockets=1)
        return odds_of(calibration.calibrated, measured, summary.loaded.mean_absolute_error)

    return ask


def test_the_same_arm_is_still_valid(ask: Ask) -> None:
    odds = ask(0, 0.0)
    assert odds.valid and odds.unchanged > 0.6
    assert "Still valid" in odds.text and "probability that this is wrong" in odds.text


@pytest.mark.parametrize("joint", [1, 3, 4])
@pytest.mark.parametrize("degrees", [0.3, -0.5])
def test_a_joint_that_shifted_is_found(ask: Ask, joint: int, degrees: float) -> None:
    odds = ask(joint, math.radians(degrees))
    assert not odds.valid and odds.unchanged < 1e-3
    assert odds.joint == f"panda_joint{joint + 1}"
    assert math.degrees(odds.offset) == pytest.approx(degrees, abs=0.06)
    assert f"likeliest cause: panda_joint{joint + 1}" in odds.text


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["panda_3", "kuka_14", "dinova_2"])
def test_real_arms_are_still_valid_at_other_placements(recordings: Path, arm: str) -> None:
    robot = mukca.load_robot(str(recordings / arm / "nominal.urdf"))
    first, *others = mukca.read_placements(recordings / arm)
    made = mukca.calibrate(robot, first, test=others[0], method="paper")
    summary = made.document.summary.test
    assert summary
    for placement in others:
        measured = measure(ten(placement.for_joints(robot.joint_names)), robot, sockets=1)
        before = summary.loaded.mean_absolute_error
        odds = odds_of(made.calibrated, measured, before, goal_for(robot))
        assert odds.valid, odds.text
