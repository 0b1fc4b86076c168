"""What is wrong with data is found and told; what is right is left alone."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.diagnostics import next_placement
from mukca.solver.results import Diagnostic

pytestmark = pytest.mark.slow


def codes(seen):
    return [finding.code for finding in seen.diagnostics]


def test_duplicates_and_stuck_joints_are_told(look, change, placements):
    front = placements[0]
    samples = list(front.samples)
    samples[1] = replace(samples[0], position=tuple(np.array(samples[0].position) + 1e-5))
    assert codes(look([replace(front, samples=tuple(samples)), *placements[1:]])) == ["duplicate"]
    assert codes(look([*placements[:2], replace(front, name="again")])) == ["copies"]  # told once
    stuck = change(front, lambda q: np.append(q[:6], 0.1))
    (found,) = (f for f in look([stuck]).diagnostics if f.code == "still")
    assert "panda_joint7" in found.text and "did not move at all" in found.text


def test_a_bad_row_in_each_of_several_files_is_named_once_and_left_out(look, change, placements):
    spoilt = []
    for k, placement in enumerate(placements):
        for row in (4 + k, 30 - k):
            turn = 0.05 * np.eye(7)[1 + k]
            placement = change(placement, lambda q, turn=turn: q + turn, slice(row, row + 1))
        spoilt.append(placement)
    seen = look(spoilt)
    told = [d for one in seen.placements for d in one.diagnostics]
    assert [d.code for d in told] == ["elsewhere"] * 6 and not seen.shared
    rows = {(d.where, d.text.partition(" in ")[2].partition(":")[0]) for d in told}
    assert len(rows) == 6 and {d.action for one in seen.placements for d in one.corrections} == {
        "leave out"
    }
    assert max(one.floor for one in seen.placements) < 2e-4


def test_the_next_placement_is_away_from_those_there_are(panda, look, placements):
    seen = look(placements[:2])
    assert "right of the robot" in next_placement(panda, seen)
    assert "front" in next_placement(panda, seen) and "left" in next_placement(panda, seen)
    moved = replace(
        seen.placements[1], diagnostics=(Diagnostic("error", "x", "there", "bad", "mend"),)
    )
    hint = next_placement(panda, replace(seen, placements=(seen.placements[0], moved)))
    assert "Correct the errors above in left" in hint and "two of them only" not in hint
    everywhere = replace(seen, shared=moved.diagnostics)
    assert next_placement(panda, everywhere) == "Correct the errors above first."
    both = replace(everywhere, placements=(seen.placements[0], moved))
    assert next_placement(panda, both) == "Correct the errors above in left first."


@pytest.mark.parametrize("noise", [2e-3, 5e-2])
def test_what_leaves_far_more_than_arms_repeat_is_never_sound(look, change, placements, noise):
    generator = np.random.default_rng(1)
    for some, sound in ((placements, []), (placements[:1], []), (placements[:1], placements[1:])):
        wild = [change(p, lambda q: q + generator.normal(0, noise, 7)) for p in some]
        seen = look([*wild, *sound])
        spoilt, others = seen.placements[: len(wild)], seen.placements[len(wild) :]
        assert min(one.floor for one in spoilt) > 1e-3
        assert all(5e-5 < one.floor < 2e-4 and not one.diagnostics for one in others)
        assert {d.level for d in seen.diagnostics} & {"error", "warning"}
        assert not sound or "floor" in [d.code for d in spoilt[0].diagnostics]
