"""A ball or a zero that differs throughout a placement trained on is an unknown of the fit."""

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


@pytest.mark.parametrize(("fault", "words"), [("ball", "ball sits 1."), ("zero", "joint4 reads")])
def test_it_is_told_and_costs_no_accuracy(panda, true_panda, remounted, fault, words):
    def recorded(name):
        differs = name == "left"
        arm = remounted if differs and fault == "ball" else true_panda
        placement = recorded_at(arm, PLACES[name], len(name), name)
        return moved(placement, placement.positions + (differs and fault == "zero") * ZERO)

    train = [recorded(name) for name in ("front", "left", "right")]
    document = calibrate(panda, train, distance=0.05, **RIGID).document
    (told,) = [check for check in document.checks if check.where.endswith("left")]
    assert words in told.text and "in left" in told.text
    assert told.code == "movement" and told.level == "warning"
    errors = [row.calibrated.mean_absolute_error for row in document.placements]
    assert max(errors) < 5e-4
