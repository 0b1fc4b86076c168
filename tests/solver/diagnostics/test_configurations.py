"""Near-duplicates: as comparing all pairs finds them, and without doing so."""

import numpy as np
import pytest

from mukca.solver.diagnostics.configurations import NEAR, near_duplicates


def test_near_duplicates_are_those_of_all_pairs():
    generator = np.random.default_rng(0)
    rows = generator.uniform(-1, 1, (300, 6))
    rows[200:] = rows[generator.integers(200, size=100)] + generator.uniform(-1, 1, (100, 6)) * 0.03
    kept = []
    expected = {}
    for i, row in enumerate(rows):
        near = [k for k in kept if np.abs(rows[k] - row).max() < NEAR]
        if near:
            expected[i] = near[0]
        else:
            kept.append(i)
    assert near_duplicates(rows) == expected
    assert 1 < len(expected) < 100


@pytest.mark.slow
def test_many_samples_are_compared():
    rows = np.random.default_rng(0).uniform(-2, 2, (30_000, 7))
    rows[20_000] = rows[10_000]
    assert near_duplicates(rows)[20_000] == 10_000
    assert near_duplicates(np.zeros((3, 1))) == {1: 0, 2: 0}
