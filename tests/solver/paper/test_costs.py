"""Eq. (5): written out, by its derivatives, and the same for both optimizers."""

import casadi as ca
import numpy as np
import pytest

from mukca.recorder import read_placement
from mukca.solver.data import cost_terms, evaluate, measure
from mukca.solver.paper import build_problem


@pytest.fixture
def problem(session, panda):
    training = [measure(read_placement(session / name), panda) for name in ("front", "left")]
    return build_problem(panda, training, regularization=1e-3)


@pytest.mark.slow
def test_the_jacobian_agrees_with_finite_differences(problem):
    generator = np.random.default_rng(0)
    x = problem.start + generator.normal(0, 0.01, len(problem.start))
    _, jacobian = problem.residuals(x)
    h = 1e-6
    for k, e in enumerate(np.eye(len(x))):
        after, before = problem.residuals(x + h * e)[0], problem.residuals(x - h * e)[0]
        assert jacobian[:, k] == pytest.approx((after - before) / (2 * h), abs=1e-8)


def test_both_optimizers_see_the_same_objective(problem):
    x = problem.start + np.random.default_rng(1).normal(0, 0.01, len(problem.start))
    symbol = ca.MX.sym("x", len(x))
    objective = ca.Function("J", [symbol], [problem.objective(symbol)])
    residuals, _ = problem.residuals(x)
    assert float(objective(x)) == pytest.approx(float(residuals @ residuals), rel=1e-12)


def test_the_objective_is_eq_5_written_out(problem):
    x = problem.start + np.random.default_rng(2).normal(0, 0.01, len(problem.start))
    expected = 0.0
    for measured in problem.training:
        points = problem.model.points(x, measured.positions)
        p0, p1 = (points[rows] for rows in measured.slices)
        N0, N1 = len(p0), len(p1)
        S0, S1 = np.cov(p0.T, bias=True), np.cov(p1.T, bias=True)
        expected += (N0 * np.trace(S0) + N1 * np.trace(S1)) / (N0 + N1)
        expected += (np.linalg.norm(p1.mean(0) - p0.mean(0)) - 0.05) ** 2
        expected += 1e-3 * np.sum((x - problem.start)[:42] ** 2)
        terms = cost_terms(points, measured)
        assert terms[0] == pytest.approx((N0 * np.trace(S0) + N1 * np.trace(S1)) / (N0 + N1))
        assert terms[1] == pytest.approx(evaluate(points, measured).distance_error ** 2)
    residuals, _ = problem.residuals(x)
    assert float(residuals @ residuals) == pytest.approx(expected, rel=1e-12)
