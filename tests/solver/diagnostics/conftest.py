"""Placements of a simulated arm, and what the checks see in them."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.data import measure
from mukca.solver.diagnostics import inspect_all
from mukca.tools.simulation import Base, record

PLACES = {"front": (0.5, 0.0, 0.1), "left": (0.35, 0.4, 0.1), "right": (0.35, -0.4, 0.1)}


@pytest.fixture(scope="session")
def record_at(true_panda):
    """Return 20 samples in each socket of a base whose centre is at a place [m]."""

    def record_at(place, seed, name="front", **more):
        base = Base(name, np.array(place), np.array([0.0, 1.0, 0.0]), **more)
        return record(true_panda, base, np.random.default_rng(seed), samples=20, noise=1e-4)

    return record_at


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
