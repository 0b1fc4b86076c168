"""Functions over rows: what CasADi computes, row by row, and no argument of another length."""

import casadi as ca
import numpy as np
import pytest

from mukca.solver.robot import ColumnFunction, RowFunction


@pytest.fixture(scope="module", params=[RowFunction, ColumnFunction])
def function(request):
    x, q = ca.SX.sym("x", 2), ca.SX.sym("q", 3)
    p = ca.vertcat(x[0] * q[0] ** 2, ca.if_else(q[1] > 0, ca.sin(q[1]) * x[1], 2 * ca.sqrt(-q[1])))
    outputs = [p, ca.jacobian(p, q), ca.sumsqr(q)]
    return request.param("f", [x, q], outputs), ca.Function("f", [x, q], outputs)


@pytest.mark.slow
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("count", [1, 17, 400, 1203])
def test_every_row_is_what_casadi_returns(function, order, count):
    of_rows, of_one = function
    x = np.array([2.0, 3.0])
    rows = np.array(np.random.default_rng(0).normal(size=(count, 3)), order=order)
    results = of_rows(rows, x)
    for i, row in enumerate(rows):
        for whole, one in zip(results, of_one(x, row), strict=True):
            np.testing.assert_allclose(whole[i], one.full().ravel(), rtol=2e-15, atol=1e-15)


def test_no_rows_give_none(function):
    shapes = [result.shape for result in function[0](np.zeros((0, 3)), np.zeros(2))]
    assert shapes == [(0, 2), (0, 6), (0, 1)]


@pytest.mark.parametrize(("x", "q"), [(2, 2), (2, 4), (1, 3), (3, 3)])
def test_another_length_is_refused(function, x, q):
    with pytest.raises(ValueError, match=r"lengths"):
        function[0](np.zeros((5, q)), np.zeros(x))
