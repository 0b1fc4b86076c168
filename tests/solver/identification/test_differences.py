"""Differences by the order of recording, which sockets in files of their own do not say."""

from dataclasses import replace

import numpy as np
import pytest

import mukca
from mukca.solver.identification.data import RobotRecordings, measure, observe
from mukca.solver.identification.model import BASE, Difference
from mukca.solver.identification.selection import orders


@pytest.mark.parametrize(("count", "course"), [(2, [-0.5, 0.5]), (3, [-0.5, 0.0, 0.5])])
def test_a_drift_goes_from_half_back_to_half_ahead(panda, count, course):
    q = np.outer(np.arange(1, count + 1), np.full(7, 0.1))
    placement = mukca.Placement.of_arrays("front", q, np.zeros(count))
    measured = measure(placement, panda, sockets=1)
    data = observe(RobotRecordings(panda, [measured]), require_scale=False)
    drift = Difference("drift", data.placements)
    assert drift.courses(data)[:, 0] == pytest.approx(course)
    assert 0 < drift.width < 0.1


def of_sockets(panda, sockets, times=False):
    """Samples of the sockets of one placement, as they are in its files."""
    q = np.outer(np.arange(1, len(sockets) + 1), np.full(7, 0.1))
    placement = mukca.Placement.of_arrays("front", q, sockets)
    samples = (
        replace(s, time=float(i) if times else None) for i, s in enumerate(placement.samples)
    )
    measured = measure(replace(placement, samples=tuple(samples)), panda, sockets=1)
    return observe(RobotRecordings(panda, [measured]))


def test_a_step_by_the_reverse_order_begins_in_the_last_socket(panda):
    data = of_sockets(panda, [0, 0, 0, 1, 1])
    by_index, in_reverse = (
        Difference("step", data.placements, BASE, clock, at=3) for clock in orders(data, "front")
    )
    assert by_index.courses(data)[:, 0].tolist() == [0, 0, 0, 1, 1]
    assert in_reverse.courses(data)[:, 0].tolist() == [0, 1, 1, 0, 0]


@pytest.mark.parametrize(("sockets", "times"), [([0, 0, 1, 1], True), ([0, 1, 0, 1], False)])
def test_times_and_sockets_in_turn_say_the_order(panda, sockets, times):
    assert orders(of_sockets(panda, sockets, times), "front") == ["index"]
