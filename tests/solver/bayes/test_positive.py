"""The bell curve that stands for one with bounds, against draws from the one with bounds."""

import numpy as np
import pytest

from mukca.solver.bayes.inference.truncated_gaussian import expectation_propagation


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_mean_spread_and_share_are_those_of_draws_within_the_bounds(seed: int) -> None:
    generator = np.random.default_rng(seed)
    A, mean = generator.normal(size=(3, 5)), generator.normal(0, 1.5, 3)
    covariance = A @ A.T
    draws = generator.multivariate_normal(mean, covariance, 400_000)
    inside = draws[(draws >= 0).all(axis=1)]
    found = expectation_propagation(mean, covariance)
    precision = np.linalg.inv(covariance)
    spread = np.linalg.inv(precision + np.diag(found.precision))
    centre = spread @ (precision @ mean + found.pull)
    deviation = inside.std(axis=0)
    assert centre == pytest.approx(inside.mean(axis=0), abs=0.05 * deviation.max())
    assert np.sqrt(np.diag(spread)) == pytest.approx(deviation, rel=0.05)
    assert found.log_share == pytest.approx(np.log(len(inside) / len(draws)), abs=0.05)


def test_what_is_far_beyond_its_bound_decays_exponentially() -> None:
    """Where the curve is steep at the bound, only exp(-slope x) is left of it."""
    found = expectation_propagation(np.array([-1000.0]), np.eye(1))
    spread = 1 / (1 + found.precision)
    assert spread**0.5 == pytest.approx(1e-3, rel=1e-3)
    assert spread * (found.pull - 1000) == pytest.approx(1e-3, rel=1e-3)
    assert found.log_share == pytest.approx(-0.5e6 - np.log(1000 * (2 * np.pi) ** 0.5), rel=1e-9)


def test_what_is_far_within_is_left_alone() -> None:
    found = expectation_propagation(np.array([8.0, 9.0]), np.array([[1.0, 0.5], [0.5, 1.0]]))
    assert np.abs([*found.precision, *found.pull, found.log_share]).max() < 1e-9
