"""Ten poses against a calibration: the same arm is valid, a shifted joint is found."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mukca
from mukca.solver.assessment import ValidityPosterior, odds_of
from mukca.solver.data import measure
from mukca.tools.recording import limit_for
from mukca.tools.simulation import Base, record

Ask = Callable[[int, float], ValidityPosterior]


@pytest.fixture(scope="module")
def calibration(panda: mukca.Robot, session: Path) -> mukca.Calibration:
    train, test = (mukca.read_placements(session / name)[0] for name in ("front", "left"))
    return mukca.calibrate(panda, train, test=test, method="paper")


def ten(placement: mukca.Placement, joint: int = 0, offset: float = 0.0) -> mukca.Placement:
    """The first ten poses of socket 0, a joint's zero shifted."""
    shift = np.zeros(placement.positions.shape[1])
    shift[joint] = offset
    poses = [s for s in placement.samples if s.socket == 0][:10]
    moved = [replace(s, position=tuple((np.array(s.position) + shift).tolist())) for s in poses]
    return replace(placement, samples=tuple(moved))


@pytest.fixture(scope="module")
def ask(calibration: mukca.Calibration, session: Path) -> Ask:
    later = mukca.read_placements(session / "right")[0]
    summary = calibration.document.summary.test
    assert summary

    def ask(joint: int, offset: float) -> ValidityPosterior:
        measured = measure(ten(later, joint, offset), calibration.robot, sockets=1)
        return odds_of(calibration.calibrated, [measured], summary.loaded.mean_absolute_error)

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


@pytest.fixture(scope="module")
def put_on_again(true_panda: mukca.Robot) -> mukca.Placement:
    """Poses of the same arm after its ball was screwed on again, 0.7 mm from where it was."""
    joint = true_panda.ball_joint
    x, y, z = joint.origin.xyz
    moved = replace(joint, origin=replace(joint.origin, xyz=(x + 6e-4, y - 3e-4, z + 2e-4)))
    arm = replace(true_panda, joints=(*true_panda.joints[:-1], moved))
    base = Base("right", np.array([0.35, -0.4, 0.1]), np.array([0.0, 1.0, 0.0]))
    return record(arm, base, np.random.default_rng(4), samples=20, noise=5e-5)


def drawn(placement: mukca.Placement, generator: np.random.Generator) -> mukca.Placement:
    first = [s for s in placement.samples if s.socket == 0]
    picked = generator.permutation(len(first))[:10]
    return replace(placement, samples=tuple(first[i] for i in picked))


@pytest.mark.slow
def test_answers_are_right_as_often_as_they_say(
    calibration: mukca.Calibration, session: Path, put_on_again: mukca.Placement
) -> None:
    """Forty draws of ten poses: the same arm, its ball put on again, and a joint off by 0.2 deg."""
    generator = np.random.default_rng(2)
    places = (mukca.read_placements(session / "right")[0], put_on_again)
    stated, wrong, named = [], 0, 0
    for draw in range(40):
        place, joint = places[draw % 2], 1 + draw % 5 if draw < 20 else None
        off = math.radians(0.2) * (-1) ** draw
        poses = ten(drawn(place, generator), joint or 0, off if joint else 0.0)
        odds = odds_of(calibration.calibrated, [measure(poses, calibration.robot, sockets=1)], 2e-4)
        stated.append(1 - odds.unchanged if odds.valid else odds.unchanged)
        wrong += odds.valid is (joint is not None)
        named += joint is not None and odds.joint == f"panda_joint{joint + 1}"
    assert wrong <= 40 * np.mean(stated) + 2
    assert wrong <= 2 and named >= 18
    assert np.mean(stated) < 0.15


def test_a_ball_that_was_put_on_again_is_no_drift(
    calibration: mukca.Calibration, put_on_again: mukca.Placement
) -> None:
    odds = odds_of(
        calibration.calibrated, [measure(ten(put_on_again), calibration.robot, sockets=1)], 6e-5
    )
    assert odds.valid and odds.error > 4 * odds.before
    assert odds.ball == pytest.approx(7e-4, abs=1.5e-4)
    assert "the ball sits 0." in odds.text and "or panda_joint7 is off" in odds.text


def test_what_one_socket_cannot_show_is_not_ruled_out(ask: Ask) -> None:
    """The first joint turns the whole arm about the socket's base, and the last the ball alone."""
    for joint in (0, 6):
        odds = ask(joint, math.radians(0.2))
        assert odds.valid and 0.02 < 1 - odds.unchanged < 0.3


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
        odds = odds_of(made.calibrated, [measured], before, limit_for(robot))
        assert odds.valid, odds.text
