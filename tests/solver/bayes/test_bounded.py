"""The bounded step against all choices of what is held at zero."""

from itertools import product

import numpy as np
import pytest

from mukca.solver.bayes.inference.active_set import active_set_step
from mukca.solver.bayes.inference.arrowhead import ArrowheadMatrix


def without_sockets(H: np.ndarray) -> ArrowheadMatrix:
    n = len(H)
    return ArrowheadMatrix(H, np.zeros((0, n)), np.zeros((0, 3, 3)), np.zeros((0, n)))


@pytest.mark.parametrize("seed", range(8))
def test_it_is_the_best_of_all_steps_within_the_bounds(seed: int) -> None:
    generator = np.random.default_rng(seed)
    root = generator.normal(0, 1, (6, 6))
    H, gradient = root @ root.T + 0.1 * np.eye(6), generator.normal(0, 1, 6)
    bounded = np.array([True, True, True, False, False, False])
    free = np.array([True, True, True, True, True, False])
    x = np.where(bounded, generator.choice([0.0, 0.3], 6), generator.normal(0, 1, 6))

    def value(d: np.ndarray) -> float:
        return float(gradient @ d + 0.5 * d @ H @ d)

    values: list[float] = []
    for choice in product([True, False], repeat=3):
        held = np.array([*choice, False, False, False])
        some = free & ~held
        d = np.where(held, -x, 0.0)
        d[some] = -np.linalg.solve(H[np.ix_(some, some)], (gradient + H @ d)[some])
        if ((x + d)[bounded] >= -1e-12).all():
            values.append(value(d))
    change, covariance = active_set_step(without_sockets(H), gradient, x, free, bounded)
    assert value(change) == pytest.approx(min(values), abs=1e-9)
    assert ((x + change)[bounded] >= 0).all() and change[5] == 0
    zero = bounded & (x + change == 0)
    assert not covariance.dense[zero].any() and not covariance.dense[5].any()


def test_it_is_exact_where_some_of_it_is_hardly_seen() -> None:
    """Exact data, two arms: the curvature's inverse alone is wrong by more than the noise."""
    generator = np.random.default_rng(1)
    axes = np.linalg.qr(generator.normal(0, 1, (40, 40)))[0]
    H = (axes * np.logspace(-12, 0, 40)) @ axes.T
    H = (H + H.T) / 2
    gradient = -H @ generator.normal(0, 1, 40)
    none = np.zeros(40, dtype=bool)
    change, _ = active_set_step(without_sockets(H), gradient, np.zeros(40), ~none, none)
    assert np.abs(H @ change + gradient).max() < 1e-13
