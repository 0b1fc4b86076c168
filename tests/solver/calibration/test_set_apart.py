"""A ball or a zero that differs throughout a placement has unknowns of its own there."""

import numpy as np
import pytest
from altered import moved
from recorded import PLACES, RIGID, recorded_at

from mukca import calibrate

ZERO = 0.01 * np.eye(7)[3]


@pytest.fixture(scope="module")
def remounted(true_panda):
    """The arm with its ball 1.5 mm elsewhere."""
    origins = true_panda.origins.copy()
    origins[-1, 1] += 1.5e-3
    return true_panda.with_origins(origins)


@pytest.mark.parametrize("fault", ["ball", "zero"])
@pytest.mark.parametrize("trained", [("front",), ("front", "left", "right")])
def test_it_is_told_set_apart_and_costs_no_accuracy(panda, true_panda, remounted, fault, trained):
    def right(name):
        differs = name == "left"
        arm = remounted if differs and fault == "ball" else true_panda
        placement = recorded_at(arm, PLACES[name], len(name), name)
        return moved(placement, placement.positions + (differs and fault == "zero") * ZERO)

    train = [right(name) for name in trained]
    test = [right(name) for name in PLACES if name not in trained]
    calibration = calibrate(panda, train, test=test, distance=0.05, **RIGID)
    done = [d for d in calibration.document.checks if d.code == "set_right"]
    assert done and all("left" in d.where or "left" in d.advice for d in done[-1:])
    errors = [row.calibrated.mean_absolute_error for row in calibration.document.placements]
    assert max(errors) < 5e-4
