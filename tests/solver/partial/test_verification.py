"""Ten poses against a calibration: the same arm is valid, a shifted joint is found."""

import math
from dataclasses import replace

import numpy as np
import pytest
from altered import moved
from recorded import PLACES, recorded_at

import mukca

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def calibration(panda, session):
    train, test = (mukca.read_placements(session / name)[0] for name in ("front", "left"))
    return mukca.calibrate(panda, train, test=test, method="paper")


def ten(placement, joint=0, offset=0.0):
    """The first ten poses of socket 0, a joint's zero shifted."""
    shift = np.zeros(placement.positions.shape[1])
    shift[joint] = offset
    poses = tuple(s for s in placement.samples if s.socket == 0)[:10]
    q = placement.positions[placement.sockets == 0][:10] + shift
    return moved(replace(placement, samples=poses), q)


@pytest.fixture(scope="module")
def ask(calibration, session):
    later = mukca.read_placements(session / "right")[0]

    def ask(joint, offset):
        return mukca.what_changed(calibration, ten(later, joint, offset), ball_moved=True)

    return ask


def unchanged(found):
    return found.probabilities["nothing"]


def valid(found):
    return found.verdict.exit_status == 0


@pytest.mark.parametrize("joint", [1, 3, 4])
@pytest.mark.parametrize("degrees", [0.3, -0.5])
def test_a_joint_that_shifted_is_found(ask, joint, degrees):
    found = ask(joint, math.radians(degrees))
    assert not valid(found) and unchanged(found) < 1e-3
    assert found.cause is not None and found.cause.joint == f"panda_joint{joint + 1}"
    assert math.degrees(found.cause.offset) == pytest.approx(-degrees, abs=0.06)
    assert f"nearest cause panda_joint{joint + 1}" in found.text


@pytest.fixture(scope="module")
def put_on_again(true_panda):
    """Poses of the same arm after its ball was screwed on again, 0.7 mm from where it was."""
    joint = true_panda.ball_joint
    x, y, z = joint.origin.xyz
    moved = replace(joint, origin=replace(joint.origin, xyz=(x + 6e-4, y - 3e-4, z + 2e-4)))
    arm = replace(true_panda, joints=(*true_panda.joints[:-1], moved))
    return recorded_at(arm, PLACES["right"], 4, "right", noise=5e-5)


def drawn(placement, generator):
    first = [s for s in placement.samples if s.socket == 0]
    picked = generator.permutation(len(first))[:10]
    return replace(placement, samples=tuple(first[i] for i in picked))


def test_answers_are_right_as_often_as_they_say(calibration, session, put_on_again):
    """Twenty draws of ten poses: the same arm, its ball put on again, a joint off by 0.2 deg."""
    generator = np.random.default_rng(2)
    places = (mukca.read_placements(session / "right")[0], put_on_again)
    stated, wrong, named = [], 0, 0
    for draw in range(20):
        place, joint = places[draw % 2], 1 + draw % 5 if draw < 10 else None
        off = math.radians(0.2) * (-1) ** draw
        poses = ten(drawn(place, generator), joint or 0, off if joint else 0.0)
        found = mukca.what_changed(calibration, poses, ball_moved=True)
        stated.append(1 - unchanged(found) if valid(found) else unchanged(found))
        wrong += valid(found) is (joint is not None)
        named += joint is not None and found.likeliest == f"panda_joint{joint + 1}"
    assert wrong <= 20 * np.mean(stated) + 2
    assert wrong <= 1 and named >= 9
    assert np.mean(stated) < 0.15


def test_a_ball_that_was_put_on_again_is_no_drift(calibration, put_on_again):
    found = mukca.what_changed(calibration, ten(put_on_again), ball_moved=True)
    assert valid(found)
    assert found.ball == pytest.approx(7e-4, abs=1.5e-4)
    assert "the ball sits 0." in found.text and "or panda_joint7 is off" in found.text
    held = mukca.what_changed(calibration, ten(put_on_again))
    assert held.likeliest in ("tool", "panda_joint7") and not valid(held)


def test_what_one_socket_cannot_show_is_not_ruled_out(ask):
    """The first joint turns the whole arm about the socket's base, and the last the ball alone."""
    for joint in (0, 6):
        found = ask(joint, math.radians(0.2))
        assert valid(found) and 0.02 < 1 - unchanged(found) < 0.3


@pytest.mark.parametrize("arm", ["panda_3", "kuka_14", "dinova_2"])
def test_real_arms_are_still_valid_at_other_placements(recordings, arm):
    robot = mukca.load_robot(str(recordings / arm / "nominal.urdf"))
    first, *others = mukca.read_placements(recordings / arm)
    made = mukca.calibrate(robot, first, test=others[0], method="paper", distance=0.05)
    for placement in others:
        found = mukca.what_changed(made, ten(placement.for_joints(robot.joint_names)))
        assert valid(found), found.text
