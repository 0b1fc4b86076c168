"""More placements than are inspected together."""

import numpy as np
import pytest
from recorded import PLACES

from mukca.solver.diagnostics import Given, inspect_all
from mukca.solver.identification.data import KnownDistance, KnownError, measure


def test_many_placements_are_inspected_with_distances_between_any(panda, record_at):
    """One of two distances is between placements that are not inspected together."""
    generator = np.random.default_rng(0)
    measured = [
        measure(record_at(PLACES["front"], generator, f"place_{k}", samples=3), panda)
        for k in range(41)
    ]
    among = [KnownDistance(("place_0", 0), (f"place_{k}", 1), 0.05) for k in (1, 40)]
    survey = inspect_all(panda, measured, Given(among))
    names = [inspection.measured.name for inspection in survey.placements]
    assert names == [m.name for m in measured]
    absent = KnownDistance(("place_0", 0), ("place_41", 0), 0.05)
    with pytest.raises(KnownError, match="place_41"):
        inspect_all(panda, measured, Given([absent]))
