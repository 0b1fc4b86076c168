"""A drift throughout one placement, by the order of recording."""

import numpy as np
import pytest

import mukca
from mukca.solver.identification.data import RobotRecordings, measure, observe
from mukca.solver.identification.model import Difference


@pytest.mark.parametrize(("count", "course"), [(2, [-0.5, 0.5]), (3, [-0.5, 0.0, 0.5])])
def test_a_drift_goes_from_half_back_to_half_ahead(panda, count, course):
    q = np.outer(np.arange(1, count + 1), np.full(7, 0.1))
    placement = mukca.Placement.of_arrays("front", q, np.zeros(count))
    measured = measure(placement, panda, sockets=1)
    data = observe(RobotRecordings(panda, [measured]), require_scale=False)
    drift = Difference("drift", data.placements)
    assert drift.courses(data)[:, 0] == pytest.approx(course)
    assert 0 < drift.width < 0.1
