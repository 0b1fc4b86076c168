"""The quick fit of a rigid arm: exact in turned frames, and as noisy as the samples."""

import numpy as np
import pytest

from mukca.solver.diagnostics import RigidModel, SeatSamples
from mukca.solver.identification.robot import turn, workspace


@pytest.fixture(scope="module")
def model(panda):
    return RigidModel(panda)


def in_frame(model, count, noise=0.0, seed=0):
    """Balls of the nominal arm in the frame of an instrument, with noise."""
    q = workspace(model.robot, count)
    balls = model.points(np.zeros(len(model.widths)), q)
    balls = balls + noise * np.random.default_rng(seed).normal(size=balls.shape)
    points = (balls - 1.0) @ turn(np.array([0.3, 2.0, -0.4]))
    return SeatSamples(q, np.zeros(count, dtype=int), points)


def test_exact_points_leave_no_errors_in_a_turned_frame(model):
    assert model.fit(in_frame(model, 30)).errors.max() < 1e-9


def test_the_noise_does_not_hang_on_the_number_of_samples(model):
    few = [model.fit(in_frame(model, 20, 1e-4, seed)).noise for seed in range(6)]
    many = model.fit(in_frame(model, 400, 1e-4)).noise
    assert np.mean(few) == pytest.approx(many, rel=0.2)
