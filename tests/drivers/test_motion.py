"""A hand's motion rests where it should, and moves smoothly in between."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mukca.drivers.arms import Motion

CONFIGURATIONS = [[0.0, 1.0], [0.5, -1.0], [0.2, 0.3]]
MOTION = Motion(CONFIGURATIONS, hold=0.5, move=0.8)


@pytest.mark.parametrize("index", range(3))
@given(within=st.floats(0, 0.5))
def test_it_rests_exactly_at_each_configuration(index: int, within: float) -> None:
    time = index * 1.3 + within * 0.999
    assert MOTION.position(time) == tuple(CONFIGURATIONS[index])


@pytest.mark.slow
@given(time=st.floats(-1, 10))
def test_it_stays_between_the_configurations_around(time: float) -> None:
    index, progress = MOTION.phase(time)
    assert 0 <= progress < 1
    here, there = CONFIGURATIONS[index], CONFIGURATIONS[min(index + 1, 2)]
    for x, a, b in zip(MOTION.position(time), here, there, strict=True):
        assert min(a, b) - 1e-12 <= x <= max(a, b) + 1e-12


def test_velocity_and_acceleration_are_continuous_and_vanish_at_rests() -> None:
    times = np.linspace(0, MOTION.duration, 20001)
    positions = np.array([MOTION.position(time) for time in times])
    step = times[1]
    velocity = np.diff(positions, axis=0) / step
    acceleration = np.diff(velocity, axis=0) / step
    assert np.abs(np.diff(velocity, axis=0)).max() < 0.01
    assert np.abs(np.diff(acceleration, axis=0)).max() < 0.1
    # the greatest speed of a minimum-jerk move is 15/8 of its mean speed
    assert np.isclose(np.abs(velocity[:, 1]).max(), 15 / 8 * 2.0 / 0.8, rtol=1e-3)


def test_it_stays_at_the_last_configuration() -> None:
    assert MOTION.duration == pytest.approx(3 * 0.5 + 2 * 0.8)
    assert MOTION.position(MOTION.duration + 1e6) == (0.2, 0.3)


@pytest.mark.parametrize("configurations", [[], [[1.0], [1.0, 2.0]]])
def test_it_needs_configurations_of_one_length(configurations: list[list[float]]) -> None:
    with pytest.raises(ValueError, match="configurations"):
        Motion(configurations)
