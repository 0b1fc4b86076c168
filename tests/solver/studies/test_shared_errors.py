"""Errors that two estimates share, and those that a movement of an instrument leaves."""

from types import SimpleNamespace

import numpy as np
import pytest

import mukca
from mukca.recorder import Placement, Sample
from mukca.solver.identification.data import STANDARD_LOAD, Measurement, Samples
from mukca.solver.studies import chance, patterns
from mukca.solver.studies.held_out_evidence import updated


class Recorded(chance.Estimate):
    """An estimate by three samples of which two are of one posture."""

    by_samples = np.random.default_rng(0).normal(size=(2, 3, 6))[[0, 1, 1]]
    by_lengths = np.zeros((6, 0))


def test_an_estimate_shares_each_of_its_errors_with_itself_once():
    positions = np.array([[0.1, 0.2], [0.3, 0.4], [0.3, 0.4]])
    data = SimpleNamespace(q=positions, seated=slice(None), known=())
    estimate = Recorded(SimpleNamespace(data=data), Samples.unloaded(positions))
    rows = Recorded.by_samples.reshape(-1, 6)
    shared = chance._by_shared_errors(estimate, estimate)
    assert shared == pytest.approx(rows.T @ rows)


def test_errors_of_points_are_without_the_movement_of_the_instrument():
    robot, generator = mukca.load_robot("panda"), np.random.default_rng(0)
    q = generator.uniform(robot.lower, robot.upper, (20, 7))
    balls = generator.normal(size=(20, 3))
    drift = np.linspace(-1e-3, 1e-3, 20)[:, None] * [1.0, 2.0, 0.0]
    measured = (balls - drift).tolist()
    pairs = zip(q.tolist(), measured, strict=True)
    samples = tuple(Sample(tuple(a), 0, point=tuple(b)) for a, b in pairs)
    placement = Placement("points", samples, robot.joint_names)
    points = Measurement(placement, 0.0, moved=drift)
    slopes = np.zeros((20, 3, 7))
    posterior = SimpleNamespace(linearise=lambda *_: (balls, slopes, slopes))
    rows, _ = patterns._rows(robot, STANDARD_LOAD, [(posterior, [points])])
    assert np.abs(rows.errors).max() < 1e-12


class Known:
    """A posterior of which no more than a covariance of the unknowns is asked."""

    model = SimpleNamespace(effects=())

    def __init__(self, covariance):
        self.of_unknowns = covariance


def test_a_covariance_below_zero_by_rounding_has_a_root():
    """Two sessions with the same postures had an eigenvalue of -7e-9 among 2568 unknowns."""
    Q, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(60, 60)))
    C = Q * np.append(np.ones(59), -7e-9) @ Q.T
    root = updated(Known(C), None, []).root
    assert np.abs(root @ root.T - C).max() < 1e-6
