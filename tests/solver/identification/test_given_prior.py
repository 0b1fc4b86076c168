"""Priors: what an earlier calibration left known in part, and widths that run away."""

import numpy as np
import pytest

from mukca.solver.identification.model import GivenPrior, PriorGroup, probabilities

PRIOR = GivenPrior(("a", "held", "c"), np.array([1.0, 2.0, 3.0]), np.diag([1.0, 1e-30, 4.0]))


@pytest.mark.parametrize(
    ("names", "left"), [((), ("a", "c")), (("a",), ("c",)), (("x",), ("a", "c"))]
)
def test_some_names_and_what_was_held_are_left_out(names, left):
    prior = PRIOR.without(names)
    assert prior.names == tuple(left)
    mean = dict(zip(PRIOR.names, PRIOR.mean.tolist(), strict=True))
    assert prior.mean.tolist() == [mean[name] for name in left]


def test_names_come_in_the_order_asked_for():
    prior = PRIOR.of(["c", "nobody", "a"])
    assert prior.names == ("c", "a") and prior.covariance.tolist() == [[4.0, 0.0], [0.0, 1.0]]


def test_probabilities_are_of_evidence_of_any_size():
    """The logarithms of the evidence of many samples are thousands."""
    expected = np.array([1.0, np.exp(-1.0)]) / (1.0 + np.exp(-1.0))
    for log_evidence in (0.0, 5000.0, -5000.0):
        logs = log_evidence - np.array([0.0, 1.0])
        assert probabilities(logs) == pytest.approx(expected)


def test_a_width_too_large_for_a_number_is_infinite():
    """Its logarithm is 300, wants to be 350, and wanted almost as much more a step ago."""
    group = PriorGroup("a", "m", np.array([0]), np.exp(300.0), trail=(299.0, 50.05))
    after = group.updated(np.array([np.exp(350.0)]), np.zeros((1, 1)), np.array([True]))
    assert after.width == np.inf
