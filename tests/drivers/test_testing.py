"""The contract finds drivers that return other states than the robot sent."""

import math
from dataclasses import replace

import pytest

from mukca.drivers import DriverContract
from mukca.drivers.arms import Mock, Motion, SimulatedArm


class Contract(DriverContract):
    joints = 2
    tolerance = 0.0


def arm(**options):
    """An arm that moves all the time, without noise, so that each state is told from all others."""
    motion = Motion([[0.1, 0.2], [0.3, -0.4]], hold=0.0, move=20.0)
    efforts = [[1.0, 2.0]] * 2
    return SimulatedArm(motion, efforts=efforts, noise=0.0, effort_noise=0.0, **options)


def sent():
    source = arm()
    return [source.state(number / source.rate) for number in range(10_000)]


class Degrees(Mock):
    def read(self, timeout):
        state = super().read(timeout)
        return replace(state, position=tuple(map(math.degrees, state.position)))


class Zeros(Mock):
    def read(self, timeout):
        return replace(super().read(timeout), position=(0.0, 0.0))


class Turned(Mock):
    def read(self, timeout):
        state = super().read(timeout)
        return replace(state, effort=tuple(-tau for tau in state.effort))


class Twice(Mock):
    """Returns some states again, with new stamps."""

    def read(self, timeout):
        state = super().read(timeout)
        self.kept = state if self._next % 10 else self.kept
        return replace(self.kept, stamp=state.stamp)


class Latest(Mock):
    """Throws away what waited, and does not count it."""

    def read(self, timeout):
        self._skip_lost()
        self.missed = 0
        return super().read(timeout)


@pytest.mark.parametrize("driver", [Degrees, Zeros, Turned, Twice])
def test_states_that_were_not_sent_are_found(driver):
    with pytest.raises(AssertionError):
        Contract().test_states_are_those_that_were_sent(driver(arm=arm()), sent)


def test_states_that_are_thrown_away_are_found():
    class Lossy(Contract):
        def driver(self, address):
            return Latest(arm=arm(buffer=0.05))

    with pytest.raises(AssertionError, match="were sent and not returned"):
        Contract().test_a_late_reader_loses_nothing(Lossy().driver(""), sent)
    with pytest.raises(AssertionError, match="nothing was lost"):
        Lossy().test_counts_what_was_missed(("", sent))
