"""Zeros by stops: right to half a degree where stops give way, and no joint named that stayed."""

import math

import numpy as np
import pytest

from mukca.drivers import JointState
from mukca.recorder import follow_to_stops
from mukca.solver.partial import zeros_by_stops

JOINTS = ("pan", "lift", "elbow", "flex", "roll")
LOWER, UPPER = np.radians([-110.0, -100, -95, -90, -160]), np.radians([110.0, 95, 90, 95, 160])
TICK = math.tau / 4096
GIVE = math.radians(0.3)


def led(rng, shift=0.0, rate=50, noise=TICK / 3):
    """States of an arm whose joints a hand leads to both stops in turn, which give way to it."""
    there, stamp = np.zeros(5), 0.0
    for joint in range(5):
        for end, side in ((LOWER, -1), (UPPER, 1), (LOWER * 0, 1)):
            goal = end[joint] + side * abs(rng.normal(0, GIVE)) * bool(end[joint])
            moves = np.linspace(there[joint], goal, rate)
            for value in (*moves, *[goal] * rate):
                there[joint] = value
                stamp += 1 / rate
                angles = there + shift + rng.normal(0, noise, 5)
                ticks = np.round(angles / TICK) % 4096
                q = np.where(ticks < 2048, ticks, ticks - 4096) * TICK
                yield JointState(stamp, tuple(q.tolist()))
    for _ in range(30 * rate):
        stamp += 1 / rate
        yield JointState(stamp, tuple(q.tolist()))


def stops(states, joints=JOINTS):
    *_, finder = follow_to_stops(states, joints, pause=3.0)
    return finder.stops()


@pytest.fixture(scope="module")
def draws():
    """Shifts of one joint's zero, and what was found, of many arms."""
    rng = np.random.default_rng(1)
    rows = []
    for draw in range(40):
        shift = np.zeros(5)
        shift[draw % 5] = math.radians(rng.choice([-1, 1]) * rng.uniform(3, 60))
        found = zeros_by_stops(stops(led(rng)).ranges, stops(led(rng, shift)).ranges)
        rows.append((shift, found))
    return rows


def test_19_of_20_zeros_are_right_to_half_a_degree(draws):
    errors = []
    for shift, found in draws:
        offsets = {zero.joint: zero.offset for zero in found.joints}
        joint = int(np.abs(shift).argmax())
        errors.append(abs(offsets[JOINTS[joint]] + shift[joint]))
    assert np.mean(np.degrees(errors) < 0.5) >= 0.95
    assert max(errors) < 3.5 * found.joints[0].standard_deviation


def test_no_joint_is_named_that_stayed(draws):
    for shift, found in draws:
        changed = [JOINTS[joint] for joint in np.flatnonzero(shift)]
        assert [zero.joint for zero in found.changed] == changed
        assert not [zero for zero in found.joints if zero.joint not in changed and zero.changed]


def test_a_turn_within_the_range_is_told(draws):
    """A joint that reads from 150 deg on passes the end of its encoder's turn."""
    rng = np.random.default_rng(3)
    before, after = stops(led(rng)), stops(led(rng, np.array([0, 0, math.radians(150), 0, 0])))
    assert after.wrapped == ("elbow",) and not before.wrapped
    found = zeros_by_stops(before.ranges, after.ranges, after.wrapped)
    (zero,) = found.changed
    assert zero.joint == "elbow" and abs(zero.offset + math.radians(150)) < math.radians(0.5)
    assert any("elbow: its reading jumps by a whole turn" in line for line in found.text)


def test_a_whole_turn_is_no_zero():
    found = zeros_by_stops({"pan": (-1.0, 1.0)}, {"pan": (math.tau - 1.0, math.tau + 1.0)})
    assert not found.changed and "pan: reads +1 whole turn" in found.text[-1]


@pytest.mark.parametrize(
    ("ranges", "said"),
    [
        ({}, "not led to its stops"),
        ({"pan": (-0.1, 0.1)}, "not led to its stops"),
        ({"pan": (-1.0, 0.8)}, "-11.5 deg of what it was"),
        ({"pan": (-4.0, 4.0)}, "turns on and on"),
    ],
)
def test_a_joint_that_is_not_told_is_named_so(ranges, said):
    found = zeros_by_stops({"pan": (-1.0, 1.0)}, ranges)
    assert not found.joints and said in found.text[0]
