"""The base of all drivers: what it lets through is whole, later than before, and in time."""

import math
from itertools import pairwise

import pytest
from cases import by_table
from driver_errors import read_until_silent, refused
from hypothesis import given
from hypothesis import strategies as st

from mukca.drivers import DriverError, JointState, Reason, ValidatingDriver


class Scripted(ValidatingDriver):
    """Receives what it is given: states, errors to raise, or numbers, which are stamps."""

    def __init__(self, *script, joints=2, period=None, clock=None):
        super().__init__("the robot", period)
        self.script = list(script)
        self.clock = clock
        self.closed = 0
        self._joint_names = tuple(f"joint{index}" for index in range(joints))

    def _receive(self, deadline):
        if not self.script:
            raise DriverError(Reason.SILENT, "no state")
        item = self.script.pop(0)
        if isinstance(item, Exception):
            raise item
        if isinstance(item, tuple):  # when it comes, by the host's clock, and its stamp
            moment, item = item
            self.clock.jump(moment)
        return item if isinstance(item, JointState) else JointState(item, (0.1, 0.2))

    def _disconnect(self):
        self.closed += 1


def stamps(driver):
    return [state.stamp for state in read_until_silent(driver)]


@pytest.fixture
def clock(virtual_time):
    virtual_time.jump(0.0)
    return virtual_time


@by_table("bad")
def test_a_bad_state_costs_itself(bad):
    """Stamp, positions and efforts; or bytes that are no state."""
    came = JointState(bad[0], *map(tuple, bad[1:])) if bad else ValueError("nonsense")
    driver = Scripted(0.1, came, 0.2)
    assert stamps(driver) == [0.1, 0.2]
    assert (driver.rejected, driver.missed, driver.closed) == (1, 0, 0)


@pytest.mark.slow
@given(st.lists(st.floats(), max_size=30))
def test_stamps_are_finite_and_grow_whatever_comes(script):
    driver = Scripted(*script, period=1e-3)
    accepted = stamps(driver)
    assert all(map(math.isfinite, accepted))
    assert all(a < b for a, b in pairwise(accepted))
    assert driver.rejected == len(script) - len(accepted)
    assert driver.missed < 1e6 * (1 + len(script))


def test_missed_states_are_counted_by_the_period():
    driver = Scripted(1.0, 1.008, 1.024, 1.0321, 1.0321 + 50 * 0.008, period=0.008)
    assert len(read_until_silent(driver)) == 5
    assert driver.missed == 1 + 49


def test_a_late_reader_gets_what_waited_and_what_comes_then(clock):
    """A pause of the reader, with a buffer that overflows meanwhile, is no jump of the clock."""
    early = [(0.01 * n, 100 + 0.01 * n) for n in range(50)]
    waited = [(30.0, 100.5 + 0.01 * n) for n in range(50)]
    now = [(30 + 0.01 * n, 130 + 0.01 * n) for n in range(50)]
    script = early + waited + now
    assert stamps(Scripted(*script, clock=clock)) == [stamp for _, stamp in script]


def test_a_reader_that_begins_late_gets_all(clock):
    waited = [(20.0, 0.01 * n) for n in range(1, 50)]
    now = [(20 + 0.01 * n, 20 + 0.01 * n) for n in range(50)]
    assert len(read_until_silent(Scripted(*waited, *now, clock=clock))) == 99


@pytest.mark.parametrize("speed", [0.5, 0.999, 1.001, 10.0])
def test_a_robot_s_clock_may_run_at_another_speed(speed, clock):
    script = [(0.01 * n, speed * 0.01 * n) for n in range(1, 5000)]
    assert len(read_until_silent(Scripted(*script, clock=clock))) == 4999


def test_a_silence_lets_as_much_time_pass_as_it_lasted(clock):
    script = [(1.0, 1.0), (100.0, 100.0), (100.1, 104.1), (100.2, 100.2)]
    assert stamps(Scripted(*script, clock=clock)) == [1.0, 100.0, 100.2]


def test_a_robot_that_sends_nothing_of_use_is_another_robot():
    with refused("PROTOCOL", match="the robot sends noise"):
        Scripted(*[ValueError("noise")] * 200).read(60.0)
    driver = Scripted(1.0, *[ValueError("noise")] * 200, 2.0)
    assert stamps(driver) == [1.0, 2.0]


def test_a_silence_says_what_was_thrown_away(clock):
    with refused("SILENT", match="the robot sends noise"):
        Scripted(ValueError("noise")).read(1.0)
    with pytest.raises(DriverError, match="no state"):
        Scripted().read(1.0)


@pytest.mark.parametrize("ends", [None, DriverError(Reason.PROTOCOL, "noise")])
def test_a_connection_is_ended_once_and_gives_nothing_then(ends):
    """By its owner, or by an error that cannot be mended."""
    driver = Scripted(0.1, ends or 0.2, 0.3)
    driver.read(1.0)
    if ends:
        with pytest.raises(DriverError, match="noise"):
            driver.read(1.0)
    else:
        driver.close()
        driver.close()
    assert driver.closed == 1
    with refused("UNREACHABLE", match="closed"):
        driver.read(1.0)


def test_a_state_that_the_constructor_waited_for_is_read_once():
    driver = Scripted(0.1, 0.2)
    driver._await_first(1.0)
    assert stamps(driver) == [0.1, 0.2]
    driver = Scripted(0.1)
    driver._await_first(1.0)
    driver.close()
    with pytest.raises(DriverError, match="closed"):
        driver.read(1.0)


def test_a_constructor_that_fails_leaves_nothing_open():
    class Failing(Scripted):
        def __init__(self, ended):
            super().__init__()
            with self._closed_on_error():
                raise KeyError

        def _disconnect(self):
            ended.append(1)

    ended = []
    with pytest.raises(KeyError):
        Failing(ended)
    assert ended == [1]
