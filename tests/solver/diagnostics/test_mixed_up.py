"""Samples that lie in another socket than they say."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import BESIDE, PLACES

from mukca.solver.diagnostics import RigidModel
from mukca.solver.diagnostics.hypotheses.ball import mixed_up
from mukca.solver.diagnostics.scene_fit import Given, scene_of
from mukca.solver.identification.data import measure


def test_a_sample_in_another_socket_is_off_by_what_is_between_them(panda, record_at):
    placement = record_at(PLACES["front"], samples=10)
    samples = list(placement.samples)
    samples[3] = replace(samples[3], socket=1)
    measured = measure(replace(placement, samples=tuple(samples)), panda)
    scene = scene_of(RigidModel(panda), [measured], Given(), None, [0.0])
    (block,) = mixed_up(scene)
    shifts = block.columns.reshape(-1, 3)
    (row,) = np.flatnonzero(shifts.any(axis=1))
    assert shifts[row] == pytest.approx(-0.05 * BESIDE, abs=2e-3)
