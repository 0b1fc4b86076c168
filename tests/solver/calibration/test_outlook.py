"""What is thought of samples that nobody has recorded yet."""

import numpy as np
import pytest

from mukca.solver.calibration.outlook import samples_on_base
from mukca.solver.identification.data import STANDARD_LOAD
from mukca.solver.identification.robot import BallModel


def test_samples_are_thought_of_in_both_sockets_of_a_base(panda):
    model, place = BallModel(panda, ()), np.array([0.5, 0.1, 0.2])
    by_socket = samples_on_base(panda, place, 0.05, STANDARD_LOAD)
    half = np.array([0.0, 0.025, 0.0])
    centres = [place - half, place + half]
    for samples, centre in zip(by_socket, centres, strict=True):
        balls = model.points(np.zeros(0), samples.q)
        assert balls == pytest.approx(np.tile(centre, (len(balls), 1)), abs=1e-6)
