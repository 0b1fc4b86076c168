"""Seats of samples: how many are enough for so many unknowns."""

import numpy as np

from mukca.solver.diagnostics import SeatSamples


def test_twice_as_many_numbers_as_unknowns_are_enough_beside_the_centres():
    """Eight samples in two seats leave six beyond the centres, with 18 numbers."""
    samples = SeatSamples(np.zeros((8, 7)), np.repeat([0, 1], 4), np.zeros((8, 3)))
    assert samples.is_overdetermined(9) and not samples.is_overdetermined(10)
