"""Simulated time: it passes as soon as everybody waits, or not before the host's has."""

import time

from mukca.drivers import clock
from mukca.tools.simulation import SimulatedTime


def test_an_hour_passes_at_once_and_those_who_repeat_something_act_meanwhile():
    ticks, began = [], time.monotonic()

    def tick():
        clock.sleep(60.0)
        ticks.append(clock.now())
        return len(ticks) < 30

    with SimulatedTime().running():
        start = clock.now()
        clock.repeat(tick, lambda: ticks.append("end"))
        clock.sleep(3600.0)
        assert 3600.0 <= clock.now() - start < 3601.0
    assert len(ticks) == 31 and ticks[-1] == "end"
    assert time.monotonic() - began < 30.0
    assert clock.now() - began < 30.0  # the host's clock is back


def test_a_paced_time_is_never_ahead_of_the_host():
    with SimulatedTime(paced=True).running():
        start, began = clock.now(), time.monotonic()
        for _ in range(20):
            clock.sleep(0.01)
            assert clock.now() - start <= time.monotonic() - began + 1e-3
