"""Placements of a simulated arm, and what the checks see in them."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.data import measure
from mukca.solver.diagnostics import inspect_all
from mukca.tools.simulation import Base, record

PLACES = {"front": (0.5, 0.0, 0.1), "left": (0.35, 0.4, 0.1), "right": (0.35, -0.4, 0.1)}


@pytest.fixture(scope="session")
def placements(true_panda):
    generator = np.random.default_rng(0)
    along_y = np.array([0.0, 1.0, 0.0])
    return [
        record(true_panda, Base(name, np.array(at), along_y), generator, samples=20, noise=1e-4)
        for name, at in PLACES.items()
    ]


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
