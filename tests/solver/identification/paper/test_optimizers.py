"""Gauss-Newton steps where they are hard: far from the minimum, and with no way down."""

import numpy as np
import pytest

from mukca.errors import NotConverged
from mukca.solver.identification.paper.optimizers import gauss_newton


def test_a_valley_is_followed_by_damping():
    """Rosenbrock's function as two residuals: full Gauss-Newton steps overshoot far from home."""

    def evaluate_residuals(x):
        J = np.array([[-1.0, 0.0], [-20 * x[0], 10.0]])
        return np.array([1 - x[0], 10 * (x[1] - x[0] ** 2)]), J

    assert gauss_newton(evaluate_residuals, np.array([-1.9, 2.0])).x == pytest.approx([1, 1])


def test_no_way_down_is_not_converged():
    def wrong(x):  # a Jacobian of the wrong sign
        return np.array([x[0] ** 2 + 1.0]), np.array([[-2 * x[0]]])

    with pytest.raises(NotConverged):
        gauss_newton(wrong, np.array([1.0]))
