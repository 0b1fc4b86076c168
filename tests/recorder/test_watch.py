"""The stream is watched: stillness is measured, and nothing broken passes for an arm at rest."""

import math
import random
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
import pytest

from mukca.drivers import JointState
from mukca.drivers.arms import Motion, SimulatedArm
from mukca.drivers.arms.simulated import Fault
from mukca.recorder.stream import JointLimits, StreamMonitor
from mukca.recorder.stream.stationarity import StationarityDetector

JOINTS = (JointLimits("a", -3, 3), JointLimits("b", -3, 3), JointLimits("c", -3, 3))
REST = (0.1, 0.2, 0.3)
PLACES = [REST, (0.6, -0.4, 1.0), (0.2, 0.5, -0.3), (-0.5, 0.1, 0.4)]


def arm(*faults: str, noise: float = 2e-5, rate: float = 1000.0) -> SimulatedArm:
    motion = Motion(PLACES, hold=1.0, move=1.0)
    return SimulatedArm(motion, rate=rate, noise=noise, faults=[Fault.parse(f) for f in faults])


def states(source: SimulatedArm, until: float) -> Iterable[JointState]:
    """What an arm without faults sends up to a moment."""
    return (state for _, state in sent(source, until))


def sent(source: SimulatedArm, until: float) -> Iterable[tuple[float, JointState]]:
    """What the arm sends up to a moment, and when; silent and repeating arms as the mock does."""
    last = None
    for k in range(round(until * source.rate)):
        moment = k / source.rate
        if source.shows("silent", moment):
            continue
        if last is None or not source.shows("repeat", moment):
            last = source.state(moment)
        yield moment, last


def fed(source: SimulatedArm, until: float, watch: StreamMonitor | None = None) -> StreamMonitor:
    watch = watch or StreamMonitor(JOINTS)
    for moment, state in sent(source, until):
        watch.feed(state, moment)
    return watch


def test_a_rest_is_averaged() -> None:
    watch = fed(arm(), 0.5)
    assert watch.trouble(0.5) is None and watch.rest is not None
    assert watch.rest.states in (300, 301)
    assert watch.rest.position == pytest.approx(REST, abs=6 * 2e-5 / math.sqrt(300))
    assert watch.rest.spread == pytest.approx((2e-5,) * 3, rel=0.3)
    assert watch.rest.effort is None


def test_efforts_are_averaged() -> None:
    still = SimulatedArm(Motion([REST]), efforts=[[1.0, 2.0, 3.0]], effort_noise=0.1)
    watch = fed(still, 0.5)
    assert watch.rest is not None and watch.rest.effort is not None
    assert watch.rest.effort == pytest.approx((1, 2, 3), abs=6 * 0.1 / math.sqrt(300))
    assert watch.rest.effort_spread == pytest.approx((0.1,) * 3, rel=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [25.0, 100.0, 1000.0])
@pytest.mark.parametrize("noise", [0.0, 2e-5, 1e-4])
def test_every_rest_is_still_and_no_move_is(rate: float, noise: float) -> None:
    source = arm(rate=rate, noise=noise)
    watch = StreamMonitor(JOINTS)
    for state in states(source, 7.0):
        watch.feed(state, state.stamp)
        within = state.stamp % 2.0
        if 0.45 < within < 0.95:
            assert watch.trouble(state.stamp) is None, state.stamp
        if 1.2 < within < 1.9 and state.stamp < 6:
            assert "still moving" in str(watch.trouble(state.stamp)), state.stamp
        if watch.settled:
            assert within < 1.2 or state.stamp > 6


@pytest.mark.parametrize("still", [2e-4, 5e-4, 2e-3])
@pytest.mark.parametrize(("share", "at_rest"), [(0.9, True), (1.2, False)])
def test_the_threshold_of_stillness_is_the_one_asked_for(
    still: float, share: float, at_rest: bool
) -> None:
    """A joint that drifts evenly by D over the window has a standard deviation of D / sqrt(12)."""
    window = StationarityDetector(JOINTS, length=0.3, still=still)
    speed = share * still * math.sqrt(12) / 0.3
    for stamp in np.linspace(0.0, 0.5, 501):
        window.add(JointState(float(stamp), (0.1, 0.2 + speed * float(stamp), 0.3), None))
    assert (window.rest is not None) == at_rest
    assert at_rest or window.moving.startswith("still moving: b by")


def test_a_watch_takes_half_a_milliradian_for_still() -> None:
    """By default, as docs and the command line say."""
    for noise, told in ((4e-4, None), (7e-4, "still moving")):
        trouble = fed(arm(noise=noise), 0.5).trouble(0.5)
        assert trouble is None if told is None else told in str(trouble)


@pytest.mark.slow
def test_a_settled_average_holds_nothing_of_the_move_before() -> None:
    watch = StreamMonitor(JOINTS)
    for state in states(arm(noise=0.0), 4.0):
        watch.feed(state, state.stamp)
        if watch.settled and state.stamp % 2 < 0.95:
            assert watch.rest is not None
            assert watch.rest.position == pytest.approx(PLACES[int(state.stamp / 2)], abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ("silent", "silent: no state for 0.4 s"),
        ("freeze", "frozen"),
        ("repeat", "stamp does not advance"),
        ("nan", "c came as nan"),
        ("jump", "c jumped by 11.5°"),
        ("zeros", "all joints read exactly 0"),
        ("short", "2 joints came, but the model has 3"),
    ],
)
@pytest.mark.parametrize("start", [2.5, 3.5])
def test_every_fault_is_told_and_bars_capture(fault: str, told: str, start: float) -> None:
    """While it shows, and afterwards until a whole window of sound states has come."""
    watch = StreamMonitor(JOINTS)
    source = arm(f"{fault}@{start}+0.4", rate=500)
    fed(source, start + 0.4, watch)
    assert told in str(watch.trouble(start + 0.4))
    after = [(m, s) for m, s in sent(source, 4.8) if m >= start + 0.4]
    for moment, state in after:
        watch.feed(state, moment)
        if moment < start + 0.65:
            assert watch.trouble(moment) is not None, moment
    assert watch.trouble(4.8) is None


@pytest.mark.parametrize("fault", ["nan", "zeros", "short", "repeat", "jump"])
def test_a_fault_of_one_state_bars_capture_for_a_window(fault: str) -> None:
    watch = StreamMonitor(JOINTS)
    for moment, state in sent(arm(f"{fault}@0.5+0.001"), 1.0):
        watch.feed(state, moment)
        if 0.3 < moment < 0.4995 or moment > 0.83:
            assert watch.trouble(moment) is None, moment
        if 0.4995 < moment < 0.76:
            assert watch.trouble(moment) is not None, moment


@pytest.mark.slow
def test_a_jump_that_stays_bars_capture_for_good() -> None:
    watch = fed(arm("jump@0.5+inf"), 7.0)
    assert "has not come back" in str(watch.trouble(7.0))


def rounded(step: float) -> Callable[[JointState], JointState]:
    return lambda state: replace(
        state, position=tuple(round(x / step) * step for x in state.position)
    )


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_an_arm_that_rounds_its_noise_away_is_not_frozen(noise: float) -> None:
    watch = StreamMonitor(JOINTS)
    for state in map(rounded(2e-5), states(arm(noise=noise), 7.0)):
        watch.feed(state, state.stamp)
        assert "frozen" not in str(watch.trouble(state.stamp))


@pytest.mark.slow
def test_an_arm_that_rounds_and_freezes_in_mid_move_is_noticed() -> None:
    watch = StreamMonitor(JOINTS)
    for state in map(rounded(2e-5), states(arm("freeze@3.4+3", noise=0.0), 4.0)):
        watch.feed(state, state.stamp)
    assert "frozen" in str(watch.trouble(4.0))


@pytest.mark.slow
def test_a_frozen_effort_alone_is_no_frozen_stream() -> None:
    source = SimulatedArm(Motion(PLACES), efforts=[[1.0] * 3] * 4, effort_noise=0.0)
    assert fed(source, 2.8).trouble(2.8) is None


def test_a_stamp_that_goes_back_is_told_and_then_followed() -> None:
    watch = fed(arm(), 0.8)
    for state in states(arm(), 0.6):
        watch.feed(state, 0.8 + state.stamp)
        if state.stamp < 0.1:
            assert "stamp went back" in str(watch.trouble(0.8 + state.stamp))
    assert watch.trouble(1.4) is None


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_efforts_that_are_no_numbers_are_a_fault(value: float) -> None:
    watch = fed(arm(), 0.5)
    watch.feed(JointState(0.5, REST, (1.0, value, 1.0)), 0.5)
    assert f"effort of b came as {value}" in str(watch.trouble(0.5))


def test_states_that_come_later_and_later_are_stale() -> None:
    watch = StreamMonitor(JOINTS)
    for state in states(arm(), 0.9):
        watch.feed(state, 2 * state.stamp)
    assert "stale: states come 0.9 s late" in str(watch.trouble(1.8))
    lenient = StreamMonitor(JOINTS, live=False)
    for state in states(arm(), 0.9):
        lenient.feed(state, 2 * state.stamp)
    assert lenient.trouble(1.8) is None


@pytest.mark.slow
def test_a_clock_that_runs_a_little_fast_is_not_stale() -> None:
    watch = StreamMonitor(JOINTS)
    for k in range(10_000):
        watch.feed(JointState(k * 0.1, (0.1 + 1e-5 * (k % 2), 0.2, 0.3)), k * 0.1 * 1.0009)
    assert "stale" not in str(watch.trouble(1000.8))


def test_too_few_states_are_told() -> None:
    watch = StreamMonitor(JOINTS)
    assert "silent: no state yet" in str(watch.trouble(0.0))
    for k in range(8):
        watch.feed(JointState(0.1 * k, (0.1 + 1e-6 * k, 0.2, 0.3)), 0.1 * k)
    assert "use a longer --window" in str(watch.trouble(0.7))


def test_rate_and_age() -> None:
    watch = fed(arm(rate=250.0), 3.0)
    assert watch.rate(3.0) == pytest.approx(250, abs=2)
    assert watch.rate(3.1) == pytest.approx(250, abs=2)  # looked at a little later
    assert watch.age(3.5) == pytest.approx(0.504)
    assert watch.rate(9.0) == 0


def test_random_nonsense_never_raises_and_never_rests() -> None:
    generator = random.Random(1)
    watch = StreamMonitor(JOINTS)
    numbers = [0.0, 1.0, -1e308, 1e308, math.nan, math.inf, -math.inf, 1e-300]
    for _ in range(3000):
        position = tuple(generator.choice(numbers) for _ in range(generator.randrange(5)))
        effort = generator.choice([None, (1.0, 2.0, 3.0), (math.nan,) * 3, ()])
        watch.feed(JointState(generator.choice(numbers), position, effort), generator.random())
        assert watch.trouble(1.0) is not None


def test_spread_is_a_standard_deviation() -> None:
    generator = np.random.default_rng(0)
    watch = StreamMonitor(JOINTS, still=1.0)
    drawn = generator.normal(0.5, 1e-3, (321, 3))
    for k, row in enumerate(drawn.tolist()):
        watch.feed(JointState(k / 1000, tuple(row)), k / 1000)
    assert watch.rest is not None
    last = round(watch.rest.stamp * 1000)
    used = drawn[last + 1 - watch.rest.states : last + 1]
    assert watch.rest.spread == pytest.approx(used.std(axis=0))
    assert watch.rest.position == pytest.approx(used.mean(axis=0))


def test_an_arm_that_was_moved_while_the_stream_was_away_did_not_jump() -> None:
    """Nor do its states come late, though the robot's clock stood meanwhile."""
    watch = fed(arm(), 0.5)
    assert watch.latest is not None
    stamp, elsewhere = watch.latest.stamp, Motion([PLACES[2]])
    for state in states(SimulatedArm(elsewhere), 0.5):
        moved = replace(state, stamp=stamp + 0.001 + state.stamp)
        watch.feed(moved, 4.0 + state.stamp, connection=1)
    assert watch.trouble(4.5) is None and watch.rest is not None
    assert watch.rest.position == pytest.approx(PLACES[2], abs=1e-5)
