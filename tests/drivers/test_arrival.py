"""Even stamps from arrivals that are not."""

import random
from itertools import pairwise

import pytest

from mukca.drivers import ArrivalTimeFilter


def stamps_of(arrivals, period=0.005):
    clock = ArrivalTimeFilter(period)
    return [clock(arrival) for arrival in arrivals]


def test_a_burst_is_spread():
    """Each fourth arrival brings four states at once, as USB adapters do."""
    arrivals = [0.02 * (number // 4) + 1e-4 * (number % 4) for number in range(400)]
    steps = [b - a for a, b in pairwise(stamps_of(arrivals)[100:])]
    assert min(steps) > 0.003
    assert max(steps) < 0.007


@pytest.mark.parametrize("true_period", [0.002, 0.005, 0.01])
def test_the_period_is_learned_and_the_clock_kept(true_period):
    generator = random.Random(0)
    arrivals = [n * true_period + generator.uniform(0, 0.002) for n in range(2000)]
    stamps = stamps_of(arrivals)
    steps = [b - a for a, b in pairwise(stamps[500:])]
    assert sum(steps) / len(steps) == pytest.approx(true_period, rel=1e-3)
    assert all(abs(s - a) < 0.003 for s, a in zip(stamps[500:], arrivals[500:], strict=True))


def test_an_interruption_is_kept():
    arrivals = [0.005 * n for n in range(100)] + [3.0 + 0.005 * n for n in range(100)]
    stamps = stamps_of(arrivals)
    assert stamps[100] == 3.0
    assert stamps[99] == pytest.approx(0.495, abs=1e-3)


def test_stamps_always_advance():
    generator = random.Random(1)
    arrivals, now = [], 0.0
    for _ in range(3000):
        now += generator.choice([0.0, 0.0, 1e-4, 0.005, 0.04, 0.3, -0.2])
        arrivals.append(now)
    assert all(a < b for a, b in pairwise(stamps_of(arrivals)))
