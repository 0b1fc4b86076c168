"""A drift throughout one placement, by the order of recording."""

import numpy as np
import pytest

from mukca.solver.identification.data import DRIFT, Apart
from mukca.solver.identification.model import shifts_by, width_of


@pytest.mark.parametrize(("order", "course"), [([0], [-0.5]), ([0, 1, 2], [-0.5, 0.0, 0.5])])
def test_a_drift_goes_from_half_back_to_half_ahead_even_of_a_single_sample(panda, order, course):
    drift = Apart(DRIFT, 1e-3)
    shifts = shifts_by(panda, np.zeros((len(order), 7)), np.array(order), drift)
    assert shifts == pytest.approx(np.array(course)[:, None, None] * np.eye(3))
    assert 0 < width_of(drift) < 0.1
