"""The rate of a stream, and how evenly its states come."""

import pytest

from mukca.tools.cli.commands.stream import Meter


def test_the_meter():
    meter = Meter()
    assert meter.read()[0] == 0
    for number in range(3001):
        meter.add(number * 0.001 + (0.004 if number % 50 == 0 else 0), waited=True)
    rate, interval, worst = meter.read()
    assert rate == pytest.approx(1000, rel=0.01)
    assert interval == pytest.approx(0.001)
    assert worst == pytest.approx(0.005, abs=1e-4)


def test_the_meter_leaves_out_states_that_were_waiting():
    """Two that came while a screen was drawn say nothing about the stream."""
    meter = Meter()
    for number in range(100):
        meter.add(number * 0.001, waited=True)
    for arrival in (0.150, 0.1501, 0.1502):
        meter.add(arrival, waited=False)
    meter.add(0.151, waited=True)
    assert meter.read()[2] == pytest.approx(0.001)
