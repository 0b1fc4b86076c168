"""A probe's tip, refitted to points that an instrument measured."""

import numpy as np
import pytest

from mukca.solver.identification.data import Pose, TipSamples, tip_shift
from mukca.solver.identification.robot import turn


@pytest.mark.parametrize("turning", [0.0, 0.5])
def test_a_tip_that_never_turns_is_held_and_one_that_does_is_found(turning):
    generator = np.random.default_rng(0)
    balls = generator.normal(0, 0.5, (20, 3))
    rotations = turn(generator.normal(0, turning, (20, 3)))
    shift = np.array([0.0, 3e-3, -5e-3])
    frame = Pose(turn(np.array([0.1, 0.2, 0.3])), np.array([1.0, 2.0, 3.0]))
    measured = frame.inverse().apply(balls + rotations @ shift)
    measured += generator.normal(0, 1e-5, measured.shape)
    found = tip_shift([TipSamples(balls, rotations, measured)])
    assert found == pytest.approx(shift if turning else np.zeros(3), abs=5e-5)
