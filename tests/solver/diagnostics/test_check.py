"""What is wrong with data is found and told; what is right is left alone."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.diagnostics import corrected, next_placement
from mukca.solver.results import Diagnostic

pytestmark = pytest.mark.slow


def codes(seen):
    return [finding.code for finding in seen.diagnostics]


def test_good_data_raise_no_alarm(look, placements):
    seen = look(placements)
    assert codes(seen) == []
    assert all(5e-5 < one.floor < 2e-4 for one in seen.placements)


def test_a_base_that_moved_is_found_and_can_be_split(look, record_at, placements):
    after = record_at([0.5012, 0.0009, 0.1], 1)
    front = placements[0]
    ones = [i for i, s in enumerate(front.samples) if s.socket == 1][8:]
    samples = list(front.samples)
    for i in ones:
        samples[i] = after.samples[i]
    seen = look([replace(front, samples=tuple(samples)), *placements[1:]])
    (correction,) = seen.placements[0].corrections
    assert correction.ranks == tuple(range(28, 40))
    assert codes(seen) == ["moved"]
    first, second, *others = corrected(
        [one.measured for one in seen.placements], [one.corrections for one in seen.placements], 2
    )[0]
    assert (first.counts, second.counts) == ((20, 8), (12,))
    assert second.name == "front, part 2" and all(one.counts == (20, 20) for one in others)


def test_samples_in_the_wrong_socket_or_far_away_are_told(look, change, placements):
    front = placements[0]
    samples = list(change(front, lambda q: q + 0.03 * np.eye(7)[1], slice(7, 8)).samples)
    samples[3] = replace(samples[3], socket=1)
    seen = look([replace(front, samples=tuple(samples)), *placements[1:]])
    assert sorted(codes(seen)) == ["far", "mislabelled"]
    assert "lies in socket 0" in " ".join(map(str, seen.placements[0].diagnostics))


def test_duplicates_and_stuck_joints_are_told(look, change, placements):
    front = placements[0]
    samples = list(front.samples)
    samples[1] = replace(samples[0], position=tuple(np.array(samples[0].position) + 1e-5))
    assert codes(look([replace(front, samples=tuple(samples)), *placements[1:]])) == ["duplicate"]
    assert codes(look([*placements[:2], replace(front, name="again")])) == ["copies"]  # told once
    stuck = change(front, lambda q: np.append(q[:6], 0.1))
    (found,) = (f for f in look([stuck]).diagnostics if f.code == "still")
    assert "panda_joint7" in found.text and "did not move at all" in found.text


def test_a_placement_that_no_model_explains_is_told(look, change, placements):
    generator = np.random.default_rng(2)
    loose = change(placements[0], lambda q: q + generator.normal(0, 2e-3, 7))
    seen = look([loose, *placements[1:]])
    assert "floor" in [finding.code for finding in seen.placements[0].diagnostics]


def test_the_next_placement_is_away_from_those_there_are(panda, look, placements):
    seen = look(placements[:2])
    assert "to its right" in next_placement(panda, seen)
    assert "front" in next_placement(panda, seen) and "left" in next_placement(panda, seen)
    moved = replace(
        seen.placements[1], diagnostics=(Diagnostic("error", "x", "there", "bad", "mend"),)
    )
    hint = next_placement(panda, replace(seen, placements=(seen.placements[0], moved)))
    assert "First mend left" in hint and "serve best" not in hint
    everywhere = replace(seen, shared=moved.diagnostics)
    assert (
        next_placement(panda, everywhere) == "First mend what all placements have: see the errors."
    )
    both = replace(everywhere, placements=(seen.placements[0], moved))
    assert next_placement(panda, both) == "First mend left: see the errors."


@pytest.mark.parametrize("noise", [2e-3, 5e-2])
def test_what_leaves_far_more_than_arms_repeat_is_never_sound(look, change, placements, noise):
    generator = np.random.default_rng(1)
    for some in (placements, placements[:1]):
        wild = [change(p, lambda q: q + generator.normal(0, noise, 7)) for p in some]
        seen = look(wild)
        assert min(one.floor for one in seen.placements) > 1e-3
        assert {d.level for d in seen.diagnostics} & {"error", "warning"}
