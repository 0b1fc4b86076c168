"""Positions of joints that turn: whole turns neither add travel nor make an arm another."""

import numpy as np
import pytest

from mukca.drivers import JointState
from mukca.recorder import Placement, arc, distinct, repeated_rows, without_turns
from mukca.recorder.session import Session
from mukca.recorder.stream import JointLimits, StreamMonitor

TURN = 2 * np.pi


@pytest.mark.parametrize("turns", [0, 1, -2])
@pytest.mark.parametrize("middle", [0.3, 3.1, -3.1, 6.2])
def test_the_arc_of_angles_is_theirs_whatever_turns_they_have(turns, middle):
    angles = middle + np.random.default_rng(1).uniform(-0.2, 0.2, 30)
    read = angles + TURN * turns * (np.arange(30) % 2)
    low, high = arc((x, x) for x in read.tolist())
    assert high - low == pytest.approx(np.ptp(angles))
    assert np.sin(low) == pytest.approx(np.sin(angles.min()))


def test_arcs_join_and_may_go_all_round():
    assert arc([(3.0, 3.2), (-3.1, -3.0)]) == pytest.approx((3.0, TURN - 3.0))
    low, high = arc([(0, 3), (2.5, 5), (4.5, 6.5)])
    assert high - low == pytest.approx(TURN)


@pytest.mark.parametrize("limit", [np.inf, TURN, 3.6])
def test_readings_of_one_posture_come_out_alike(limit):
    true = np.random.default_rng(2).uniform(-3, -2, (20, 1))
    limits = np.array([-limit]), np.array([limit]), [True]
    gained = true + TURN * (np.arange(20) >= 14)[:, None]
    for read in (true, gained, true % TURN):
        found = without_turns(read, *limits)
        assert np.ptp(found) == pytest.approx(np.ptp(true))
        assert np.abs((found - true + np.pi) % TURN - np.pi).max() < 1e-12
    assert np.array_equal(without_turns(true, *limits), true)


def test_what_slides_or_is_outside_all_the_same_stays():
    read = np.array([[0.0, 5.0], [7.0, 1.0]])
    lower, upper = np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    assert np.array_equal(without_turns(read, lower, upper, [False, True]), read)


@pytest.mark.parametrize("copies", [1, 2, 9])
def test_equal_rows_count_once_and_it_is_said(copies):
    q = np.random.default_rng(0).uniform(-1, 1, (7, 4))
    rows = np.concatenate([q, *[q + 4e-7] * copies])
    placement = Placement.of_arrays("front", rows, [0] * len(rows))
    counted = distinct(placement)
    assert np.array_equal(counted.positions, q)
    assert f"{7 * copies} of {len(rows)} samples repeat another one" in counted.remarks[0]
    other_socket = Placement.of_arrays("front", rows[:14], [0] * 7 + [1] * 7)
    assert distinct(other_socket) is other_socket


def test_rows_that_differ_in_one_number_are_no_copies():
    rows = np.zeros((50, 3))
    rows[:, 1] = np.repeat(np.arange(25), 2) * 1e-3
    rows[1::2, 2] = 2e-6
    assert repeated_rows(rows) == set()
    assert repeated_rows(np.concatenate([rows, rows[::-1]])) == set(range(50, 100))


def monitor(joints):
    return StreamMonitor(joints, window=0.3, still=5e-4, live=False)


@pytest.mark.parametrize("turns", [1, 2, 3])
@pytest.mark.parametrize("prismatic", [False, True])
def test_turns_between_two_states_are_no_jump(prismatic, turns):
    joint = JointLimits("wrist", -TURN, TURN, prismatic)
    watch = monitor([joint])
    for i in range(60):
        noise = 1e-5 * np.sin(7.0 * i)
        read = 3.1416 + noise - TURN * turns * (i % 3 == 0 if i > 20 else 0)
        watch.feed(JointState(0.02 * i, (read,), None), 0.02 * i)
    trouble = watch.trouble(1.2)
    assert (trouble is None) == (not prismatic)
    if not prismatic:
        assert abs(watch.rest.position[0]) == pytest.approx(np.pi, abs=1e-4)


def test_a_session_knows_a_pose_and_its_limits_by_the_circle():
    session = Session((JointLimits("a", -3.0, 3.0), JointLimits("z", -1.0, 1.0, prismatic=True)))
    assert session.same((3.0, 0.1), (3.0 - TURN, 0.1))
    assert not session.same((0.1, 3.0), (0.1, 3.0 - TURN))
    assert session.refusal((1.0 + TURN, 0.1)) is None
    assert "outside its limits" in session.refusal((0.1, 1.0 + TURN))
