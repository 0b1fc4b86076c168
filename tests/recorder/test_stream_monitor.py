"""The stream is watched: stillness is measured, and nothing broken passes for an arm at rest."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from altered import write_rows

from mukca.drivers import DriverError, JointState, open_driver
from mukca.recorder.stream import JointLimits, StreamMonitor

JOINTS = (JointLimits("a", -3, 3), JointLimits("b", -3, 3), JointLimits("c", -3, 3))
REST = (0.1, 0.2, 0.3)
PLACES = [REST, (0.6, -0.4, 1.0), (0.2, 0.5, -0.3), (-0.5, 0.1, 0.4)]


@pytest.fixture
def sent(tmp_path, virtual_time):
    """What a simulated arm sends up to a moment, and when."""

    def sent(until, *faults, noise=2e-5, rate=1000.0):
        file = write_rows(tmp_path / "hand.csv", PLACES)
        options = [f"rate={rate}&noise={noise}", *(f"fault={fault}" for fault in faults)]
        driver = open_driver("mock", f"{file}?{'&'.join(options)}")
        begun = virtual_time.now()
        while (left := begun + until - virtual_time.now()) > 1e-5:
            try:
                state = driver.read(left)
            except DriverError:  # silent until then
                return
            yield virtual_time.now() - begun, state

    return sent


def fed(states):
    monitor = StreamMonitor(JOINTS)
    for moment, state in states:
        monitor.feed(state, moment)
    return monitor


def still(stamp, position=REST, effort=None):
    """A state of an arm at rest, with a little noise."""
    noise = 1e-5 * math.sin(1e4 * stamp)
    return JointState(stamp, tuple(q + noise for q in position), effort)


def test_positions_and_efforts_are_averaged_with_their_standard_deviations():
    generator = np.random.default_rng(0)
    monitor = StreamMonitor(JOINTS, still=1.0)
    drawn = generator.normal(0.5, 1e-3, (321, 3))
    for k, row in enumerate(drawn.tolist()):
        monitor.feed(JointState(k / 1000, tuple(row), tuple(2 * q for q in row)), k / 1000)
    rest = monitor.rest
    last = round(rest.stamp * 1000)
    used = drawn[last + 1 - rest.states : last + 1]
    assert rest.position == pytest.approx(used.mean(axis=0))
    assert rest.spread == pytest.approx(used.std(axis=0))
    assert rest.effort == pytest.approx(2 * used.mean(axis=0))
    assert rest.effort_spread == pytest.approx(2 * used.std(axis=0))


@pytest.mark.slow
@pytest.mark.parametrize("rate", [25.0, 100.0, 1000.0])
@pytest.mark.parametrize("noise", [0.0, 2e-5, 1e-4])
def test_every_rest_is_still_and_no_move_is(sent, rate, noise):
    monitor = StreamMonitor(JOINTS)
    for _, state in sent(7.0, noise=noise, rate=rate):
        monitor.feed(state, state.stamp)
        within = state.stamp % 2.0
        if 0.45 < within < 0.95:
            assert monitor.trouble(state.stamp) is None, state.stamp
        if 1.2 < within < 1.9 and state.stamp < 6:
            assert "still moving" in str(monitor.trouble(state.stamp)), state.stamp
        if monitor.settled:
            assert within < 1.2 or state.stamp > 6
            if noise == 0.0 and within < 0.95:  # nothing of the move before is in the average
                assert monitor.rest is not None
                place = PLACES[int(state.stamp / 2)]
                assert monitor.rest.position == pytest.approx(place, abs=1e-12)


@pytest.mark.parametrize("still", [2e-4, 5e-4, 2e-3])
@pytest.mark.parametrize(("share", "at_rest"), [(0.9, True), (1.2, False)])
def test_the_threshold_of_stillness_is_the_one_asked_for(still, share, at_rest):
    """A joint that drifts evenly by D over the window has a standard deviation of D / sqrt(12).

    By default it is half a milliradian, as docs and the command line say.
    """
    monitor = StreamMonitor(JOINTS) if still == 5e-4 else StreamMonitor(JOINTS, still=still)
    speed = share * still * math.sqrt(12) / 0.3
    for stamp in np.linspace(0.0, 0.5, 501).tolist():
        monitor.feed(JointState(stamp, (0.1, 0.2 + speed * stamp, 0.3), None), stamp)
    assert (monitor.rest is not None) == at_rest
    assert at_rest or monitor.moving.startswith("still moving: b by")


@pytest.mark.parametrize("fault", ["nan", "zeros", "short", "repeat", "jump"])
def test_a_fault_of_one_state_bars_capture_for_a_window(sent, fault):
    monitor = StreamMonitor(JOINTS)
    for moment, state in sent(1.0, f"{fault}@0.5+0.001"):
        monitor.feed(state, moment)
        if 0.3 < moment < 0.4995 or moment > 0.83:
            assert monitor.trouble(moment) is None, moment
        if 0.4995 < moment < 0.76:
            assert monitor.trouble(moment) is not None, moment


@pytest.mark.slow
def test_a_jump_that_stays_bars_capture_for_good(sent):
    assert "has not come back" in str(fed(sent(7.0, "jump@0.5+inf")).trouble(7.0))


def rounded(state, step=2e-5):
    return replace(state, position=tuple(round(x / step) * step for x in state.position))


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_an_arm_that_rounds_its_noise_away_is_not_frozen(sent, noise):
    monitor = StreamMonitor(JOINTS)
    for moment, state in sent(7.0, noise=noise):
        monitor.feed(rounded(state), moment)
        assert "frozen" not in str(monitor.trouble(moment))


def test_an_arm_that_rounds_and_freezes_in_mid_move_is_noticed(sent):
    states = ((moment, rounded(state)) for moment, state in sent(4.0, "freeze@3.4+3", noise=0.0))
    assert "frozen" in str(fed(states).trouble(4.0))


def test_a_frozen_effort_alone_is_no_frozen_stream(sent):
    states = ((moment, replace(state, effort=(1.0,) * 3)) for moment, state in sent(2.8))
    assert fed(states).trouble(2.8) is None


def test_a_stamp_that_goes_back_is_told_and_then_followed(sent):
    monitor = fed(sent(0.8))
    for moment, state in sent(0.6):
        monitor.feed(state, 0.8 + moment)
        if moment < 0.1:
            assert "stamp went back" in str(monitor.trouble(0.8 + moment))
    assert monitor.trouble(1.4) is None


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_efforts_that_are_no_numbers_are_a_fault(sent, value):
    monitor = fed(sent(0.5))
    monitor.feed(JointState(0.5, REST, (1.0, value, 1.0)), 0.5)
    assert f"effort of b came as {value}" in str(monitor.trouble(0.5))


@pytest.mark.parametrize(("live", "told"), [(True, "stale: states come 0.9 s late"), (False, None)])
def test_states_that_come_later_and_later_are_stale(live, told):
    monitor = StreamMonitor(JOINTS, live=live)
    for k in range(900):
        monitor.feed(still(k / 1000), 2 * k / 1000)
    trouble = monitor.trouble(1.8)
    assert trouble is None if told is None else told in str(trouble)


def test_a_clock_that_runs_a_little_fast_is_not_stale():
    monitor = StreamMonitor(JOINTS)
    for k in range(10_000):
        monitor.feed(still(k * 0.1), k * 0.1 * 1.0009)
    assert "stale" not in str(monitor.trouble(1000.8))


def test_too_few_states_are_told():
    monitor = StreamMonitor(JOINTS)
    assert "silent: no state yet" in str(monitor.trouble(0.0))
    for k in range(8):
        monitor.feed(still(0.1 * k), 0.1 * k)
    assert "use a longer --window" in str(monitor.trouble(0.7))


@pytest.mark.parametrize(("rate", "window"), [(3, 1.9), (5, 1.1), (8, 0.7)])
def test_a_slow_stream_is_told_its_window_and_rests_by_it(rate, window):
    short, long = StreamMonitor(JOINTS), StreamMonitor(JOINTS, window=window)
    for k in range(40):
        for monitor in (short, long):
            monitor.feed(still(k / rate), k / rate)
    end = 39 / rate
    assert f"use a longer --window, {window:g}" in str(short.trouble(end + 1.5 / rate))
    assert long.trouble(end) is None and long.rest.states >= 5
    assert "silent" in str(long.trouble(end + 3 / rate))


def test_rate_and_age(sent):
    monitor = fed(sent(3.0, rate=250.0))
    assert monitor.rate(3.0) == pytest.approx(250, abs=2)
    assert monitor.rate(3.1) == pytest.approx(250, abs=2)  # looked at a little later
    assert monitor.age(3.5) == pytest.approx(0.5, abs=5e-3)
    assert monitor.rate(9.0) == 0


def test_random_nonsense_never_raises_and_never_rests():
    generator = random.Random(1)
    monitor = StreamMonitor(JOINTS)
    numbers = [0.0, 1.0, -1e308, 1e308, math.nan, math.inf, -math.inf, 1e-300]
    for _ in range(3000):
        position = tuple(generator.choice(numbers) for _ in range(generator.randrange(5)))
        effort = generator.choice([None, (1.0, 2.0, 3.0), (math.nan,) * 3, ()])
        monitor.feed(JointState(generator.choice(numbers), position, effort), generator.random())
        assert monitor.trouble(1.0) is not None


def test_an_arm_that_was_moved_while_the_stream_was_away_did_not_jump():
    """Nor do its states come late, though the robot's clock stood meanwhile."""
    monitor = StreamMonitor(JOINTS)
    for k in range(500):
        monitor.feed(still(k / 1000), k / 1000)
    for k in range(500):
        monitor.feed(still(0.5 + k / 1000, PLACES[2]), 4.0 + k / 1000, connection=1)
    assert monitor.trouble(4.5) is None and monitor.rest is not None
    assert monitor.rest.position == pytest.approx(PLACES[2], abs=1e-5)


def test_a_clock_of_the_robot_that_stood_and_moves_again_is_followed():
    """The arm was moved meanwhile; the robot's clock goes on where it stood."""
    monitor = StreamMonitor(JOINTS)
    for k in range(500):
        monitor.feed(still(k / 1000), k / 1000)
    for k in range(500, 4000):
        monitor.feed(still(0.499, PLACES[2]), k / 1000)
    assert "does not advance" in str(monitor.trouble(4.0))
    for k in range(4000, 4250):
        monitor.feed(still(0.5 + k / 1000 - 4.0, PLACES[2]), k / 1000)
        assert monitor.rest is None
    for k in range(4250, 4500):
        monitor.feed(still(0.5 + k / 1000 - 4.0, PLACES[2]), k / 1000)
    assert monitor.trouble(4.5) is None
    assert monitor.rest.position == pytest.approx(PLACES[2], abs=1e-5)


def test_a_state_that_came_twice_is_no_clock_that_stood():
    """Else it would hide a jump."""
    monitor = StreamMonitor(JOINTS)
    for k in range(1000):
        position = PLACES[2] if k > 500 else REST
        monitor.feed(still(k / 1000 - 0.001 * (k == 500), position), k / 1000)
    assert "jumped" in str(monitor.trouble(1.0))
