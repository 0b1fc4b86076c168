"""The level of a cause follows from what it does to distances."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.diagnostics import Given, inspect_all
from mukca.solver.identification.data import STANDARD_LOAD, measure

pytestmark = pytest.mark.slow


def test_a_ball_that_was_not_seated_once_hardly_counts(look, change, placements):
    lifted = change(placements[0], lambda q: q + 0.02 * np.eye(7)[1], slice(7, 8))
    (finding,) = look([lifted, *placements[1:]]).diagnostics
    assert (finding.code, finding.level) == ("far", "note")
    assert finding.consequence.near < 3e-5 and finding.consequence.workspace < 1e-4


def test_a_move_counts_by_what_it_does_to_the_placements_trained_on(panda, record_at, placements):
    after = record_at([0.5, 0.02, 0.1], 1)
    front = placements[0]
    odd = [i for i, s in enumerate(front.samples) if s.socket == 1][10:]
    samples = [after.samples[i] if i in odd else s for i, s in enumerate(front.samples)]
    moved = replace(front, samples=tuple(samples))
    every = [measure(p, panda, None, sockets=1) for p in (moved, *placements[1:])]

    def finding(trained):
        given = Given(load=STANDARD_LOAD, trained=trained)
        seen = inspect_all(panda, every, given).diagnostics
        return next(one for one in seen if one.code == "moved")

    alone, among = finding(("front",)), finding(())
    assert alone.level == "error" and "effect on distances: " in str(alone)
    assert alone.consequence.workspace > 2 * among.consequence.workspace > 0
    held_out = finding(("left", "right"))
    assert (held_out.level, held_out.consequence) == ("warning", None)


def test_a_zero_that_is_off_throughout_a_placement_is_told_so(look, change, placements):
    off = change(placements[1], lambda q: q + np.deg2rad(0.6) * np.eye(7)[3])
    (finding,) = look([placements[0], off, placements[2]]).diagnostics
    assert "throughout left" in finding.text and "sample " not in str(finding)
    assert finding.level == "error" and finding.consequence.workspace > 3e-4
