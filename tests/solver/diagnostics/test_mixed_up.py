"""Samples that lie in another socket than they say."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import BESIDE, PLACES

from mukca.solver.diagnostics import RigidModel, inspect_all
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


@pytest.mark.parametrize(
    ("spoilt", "where"), [(("front", "left"), ["all placements"]), (("front",), ["front"])]
)
def test_files_that_were_all_recorded_in_one_socket_are_named(panda, record_at, spoilt, where):
    """Half the samples of socket 0 stand in the file of socket 1."""
    measurements = []
    for name in ("front", "left"):
        placement = record_at(PLACES[name], samples=40)
        if name in spoilt:
            samples = [sample for sample in placement.samples if sample.socket == 0]
            halves = [replace(sample, socket=i % 2) for i, sample in enumerate(samples)]
            placement = replace(placement, samples=tuple(halves))
        measurements.append(measure(replace(placement, name=name), panda))
    survey = inspect_all(panda, measurements)
    errors = [d for d in survey.diagnostics if d.level == "error"]
    assert [d.code for d in errors] == ["one-socket"] * len(where)
    assert [d.where for d in errors] == where
    assert survey.hypotheses[0].name == "one_socket"
