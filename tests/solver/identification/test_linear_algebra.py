"""The method's linear algebra, against what it stands for: whole matrices, all choices, draws."""

from itertools import product

import numpy as np
import pytest

from mukca.solver.identification.data import Known, common_precision, distance_covariance
from mukca.solver.identification.inference.arrow import Arrow, Form
from mukca.solver.identification.inference.bounds import expectation_propagation
from mukca.solver.identification.inference.normal_equations import BoundedProblem, NormalEquations
from mukca.solver.identification.model import log_determinant, scaled_inverse


@pytest.mark.parametrize("seed", range(3))
def test_the_inverse_of_what_is_free_is_zero_for_what_is_held(seed):
    generator = np.random.default_rng(seed)
    root = generator.normal(0, 1, (5, 5)) * np.logspace(-2, 2, 5)
    H, free = root.T @ root, np.array([True, True, False, True, True])
    some = np.ix_(free, free)
    expected = np.zeros_like(H)
    expected[some] = np.linalg.inv(H[some])
    assert Arrow(H, free).inverse == pytest.approx(expected, rel=1e-7, abs=1e-10)
    assert log_determinant(H) == pytest.approx(np.linalg.slogdet(H)[1])


@pytest.mark.parametrize("seed", range(3))
def test_an_arrow_is_the_whole_curvature(seed):
    """Two cells that share an error, beside unknowns of all samples, one of which is held."""
    generator = np.random.default_rng(seed)
    cells = [np.array([4, 5, 8]), np.array([6, 7])]
    parts = []
    for cell in cells:
        some = generator.normal(0, 1, (12, 9))
        some[:, np.setdiff1d(np.arange(4, 9), cell)] = 0.0
        parts.append(some * np.logspace(-2, 2, 9))
    J = np.concatenate(parts)
    F = np.zeros((9, 1))
    F[4:, 0] = 0.3 * np.logspace(-2, 2, 9)[4:]
    H = J.T @ J - F @ F.T
    free = np.arange(9) != 1
    arrow = Arrow(H, free, Form(cells, F))
    some = np.ix_(free, free)
    expected = np.zeros_like(H)
    expected[some] = np.linalg.inv(H[some])
    assert arrow.inverse == pytest.approx(expected, rel=1e-7, abs=1e-12)
    assert arrow.log_determinant == pytest.approx(np.linalg.slogdet(H[some])[1])
    assert arrow.gaussian(np.zeros(9)).covariance == pytest.approx(expected, rel=1e-7, abs=1e-12)


def test_readings_of_one_base_tell_less_than_others():
    """Of seven distances three are of one base, two of another, and one is of none."""
    bases = [0.05, 0.08, 0.05, 0.09, 0.08, 0.05]
    lengths = [
        Known(2 * k, 2 * k + 1, d, 1e-5 * (k + 1), on_base=True) for k, d in enumerate(bases)
    ]
    lengths.append(Known(0, 3, 0.05, 4e-5))
    C, Q = distance_covariance(lengths), common_precision(lengths)
    alone = np.linalg.inv(C) + Q @ Q.T
    assert alone == pytest.approx(np.diag(np.diag(alone)), rel=1e-9, abs=1e-9 * alone.max())
    assert (np.diag(alone) > np.diag(np.linalg.inv(C)))[:6].all()


@pytest.mark.parametrize("seed", range(8))
def test_it_is_the_best_of_all_steps_within_the_bounds(seed):
    generator = np.random.default_rng(seed)
    root = generator.normal(0, 1, (6, 6))
    H, gradient = root @ root.T + 0.1 * np.eye(6), generator.normal(0, 1, 6)
    bounded = np.array([True, True, True, False, False, False])
    free = np.array([True, True, True, True, True, False])
    x = np.where(bounded, generator.choice([0.0, 0.3], 6), generator.normal(0, 1, 6))

    def value(d):
        return float(gradient @ d + 0.5 * d @ H @ d)

    values = []
    for choice in product([True, False], repeat=3):
        held = np.array([*choice, False, False, False])
        some = free & ~held
        d = np.where(held, -x, 0.0)
        d[some] = -np.linalg.solve(H[np.ix_(some, some)], (gradient + H @ d)[some])
        if ((x + d)[bounded] >= -1e-12).all():
            values.append(value(d))
    equations = NormalEquations(H, gradient)
    change, covariance = BoundedProblem(equations, x, free, bounded).solution()
    assert value(change) == pytest.approx(min(values), abs=1e-9)
    assert ((x + change)[bounded] >= 0).all() and change[5] == 0
    zero = bounded & (x + change == 0)
    assert not covariance[zero].any() and not covariance[5].any()


def test_it_is_exact_where_some_of_it_is_hardly_seen():
    """Exact data, two arms: the curvature's inverse alone is wrong by more than the noise."""
    generator = np.random.default_rng(1)
    axes = np.linalg.qr(generator.normal(0, 1, (40, 40)))[0]
    H = (axes * np.logspace(-12, 0, 40)) @ axes.T
    H = (H + H.T) / 2
    gradient = -H @ generator.normal(0, 1, 40)
    none = np.zeros(40, dtype=bool)
    equations = NormalEquations(H, gradient)
    change = BoundedProblem(equations, np.zeros(40), ~none, none).solution().change
    assert np.abs(H @ change + gradient).max() < 1e-13


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_mean_spread_and_share_are_those_of_draws_within_the_bounds(seed):
    generator = np.random.default_rng(seed)
    A, mean = generator.normal(size=(3, 5)), generator.normal(0, 1.5, 3)
    covariance = A @ A.T
    draws = generator.multivariate_normal(mean, covariance, 400_000)
    inside = draws[(draws >= 0).all(axis=1)]
    tau, pull, log_share = expectation_propagation(mean, covariance)
    precision = np.linalg.inv(covariance)
    spread = np.linalg.inv(precision + np.diag(tau))
    centre = spread @ (precision @ mean + pull)
    deviation = inside.std(axis=0)
    assert centre == pytest.approx(inside.mean(axis=0), abs=0.05 * deviation.max())
    assert np.sqrt(np.diag(spread)) == pytest.approx(deviation, rel=0.05)
    assert log_share == pytest.approx(np.log(len(inside) / len(draws)), abs=0.05)


def test_what_is_far_beyond_its_bound_decays_exponentially():
    """Where the curve is steep at the bound, only exp(-slope x) is left of it."""
    tau, pull, log_share = expectation_propagation(np.array([-1000.0]), np.eye(1))
    spread = 1 / (1 + tau)
    assert spread**0.5 == pytest.approx(1e-3, rel=1e-3)
    assert spread * (pull - 1000) == pytest.approx(1e-3, rel=1e-3)
    assert log_share == pytest.approx(-0.5e6 - np.log(1000 * (2 * np.pi) ** 0.5), rel=1e-9)


def test_what_is_far_within_is_left_alone():
    found = expectation_propagation(np.array([8.0, 9.0]), np.array([[1.0, 0.5], [0.5, 1.0]]))
    assert np.abs(np.hstack(found)).max() < 1e-9


@pytest.mark.parametrize(
    "matrix", [[[-1.0, 0.0], [0.0, 1.0]], [[1.0, 2.0], [2.0, 1.0]], [[np.nan, 0.0], [0.0, 1.0]]]
)
def test_what_is_no_covariance_has_no_inverse(matrix):
    with pytest.raises(np.linalg.LinAlgError, match="not positive"):
        scaled_inverse(np.array(matrix))
