"""Placements of a simulated arm, and what the checks see in them."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from recorded import PLACES, recorded_at

from mukca.solver.diagnostics import inspect_all
from mukca.solver.identification.data import measure


@pytest.fixture(scope="session")
def record_at(true_panda):
    """Record that arm at a place, 20 samples in each socket."""
    return partial(recorded_at, true_panda)


@pytest.fixture(scope="session")
def placements(record_at):
    generator = np.random.default_rng(0)
    return [record_at(place, generator, name) for name, place in PLACES.items()]


@pytest.fixture(scope="session")
def look(panda):
    def look(placements, distance=None):
        measured = [measure(p, panda, distance, sockets=1) for p in placements]
        return inspect_all(panda, measured)

    return look


@pytest.fixture(scope="session")
def change():
    def change(placement, of, rows=slice(None)):
        """Return a placement with the joint positions of some samples changed."""
        samples = list(placement.samples)
        for i in range(len(samples))[rows]:
            q = of(np.array(samples[i].position))
            samples[i] = replace(samples[i], position=tuple(q.tolist()))
        return replace(placement, samples=tuple(samples))

    return change
