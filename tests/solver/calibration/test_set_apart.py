"""A ball or a zero that differs throughout a placement has unknowns of its own there."""

from dataclasses import replace

import numpy as np
import pytest

from mukca import calibrate
from mukca.tools.simulation import Base, record

PLACES = {"front": (0.5, 0.0, 0.1), "left": (0.35, 0.4, 0.1), "right": (0.35, -0.4, 0.1)}
ZERO = 0.01


def recorded(robot, name):
    base = Base(name, np.array(PLACES[name]), np.array([0.0, 1.0, 0.0]))
    generator = np.random.default_rng(len(name))
    return record(robot, base, generator, samples=20, noise=1e-4)


@pytest.fixture(scope="module")
def remounted(true_panda):
    """The arm with its ball 1.5 mm elsewhere."""
    origins = true_panda.origins.copy()
    origins[-1, 1] += 1.5e-3
    return true_panda.with_origins(origins)


def off(placement):
    shift = ZERO * np.eye(7)[3]
    samples = [
        replace(s, position=tuple((np.array(s.position) + shift).tolist()))
        for s in placement.samples
    ]
    return replace(placement, samples=tuple(samples))


@pytest.mark.parametrize("fault", ["ball", "zero"])
@pytest.mark.parametrize("trained", [("front",), ("front", "left", "right")])
def test_it_is_told_set_apart_and_costs_no_accuracy(panda, true_panda, remounted, fault, trained):
    def right(name):
        differs = name == "left"
        placement = recorded(remounted if differs and fault == "ball" else true_panda, name)
        return off(placement) if differs and fault == "zero" else placement

    train = [right(name) for name in trained]
    test = [right(name) for name in PLACES if name not in trained]
    calibration = calibrate(panda, train, test=test, distance=0.05)
    done = [d for d in calibration.document.checks if d.code == "set_right"]
    assert done and all("left" in d.where or "left" in d.advice for d in done[-1:])
    errors = [row.calibrated.mean_absolute_error for row in calibration.document.placements]
    assert max(errors) < 5e-4
