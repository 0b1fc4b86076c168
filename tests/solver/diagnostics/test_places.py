"""Samples of another place are known for what they are, and named by the right row."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import recorded_by_servos

from mukca.solver.diagnostics import inspect_all
from mukca.solver.identification.data import measure
from mukca.solver.identification.robot import load_robot
from mukca.tools.simulation import Imperfection, perturb, reachable_bases, record

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def elsewhere(record_at):
    """The front placement with its base 371 mm away, half of it to the left."""
    return record_at([0.5 - 0.321, 0.186, 0.1], 1)


@pytest.mark.parametrize("first", [3, 10, 17])
def test_a_base_that_moved_far_is_told_by_the_first_row(look, placements, elsewhere, first):
    front = placements[0]
    samples = (*front.samples[: 20 + first], *elsewhere.samples[20 + first :])
    seen = look([replace(front, samples=samples), *placements[1:]])
    (finding,) = seen.diagnostics
    assert finding.code == "moved" and f"before sample {first + 1} of socket 1" in finding.text
    (finding,) = seen.hypotheses[:1]
    assert finding.parameters["size"] == pytest.approx(0.371, abs=1e-3)


def test_a_base_that_moved_far_before_a_socket_was_entered_has_a_size(look, placements, elsewhere):
    before, after = placements[0].samples, elsewhere.samples
    samples = (*before[:10], *after[20:30], *after[10:20], *after[30:])
    seen = look([replace(placements[0], samples=samples), *placements[1:]])
    told = " ".join(map(str, seen.diagnostics))
    assert "moved" in told and "nan" not in told


@pytest.mark.parametrize(("begin", "many"), [(0, 1), (6, 2), (0, 5), (6, 9)])
def test_samples_of_the_other_socket_are_told(look, record_at, placements, begin, many):
    more = record_at([0.5, 0.0, 0.1], 2)
    samples = list(placements[0].samples)
    for i in range(20 + begin, 20 + begin + many):
        samples[i] = replace(more.samples[i - 20], socket=1)
    seen = look([replace(placements[0], samples=tuple(samples)), *placements[1:]])
    assert {f.code for f in seen.diagnostics} == {"mislabelled"}
    told = " ".join(map(str, seen.diagnostics))
    assert "the socket number is wrong" in told
    if len(seen.diagnostics) == 1:
        assert f"samples {begin + 1} to {begin + many} of socket 1 lie in socket 0" in told or (
            many == 1 and f"sample {begin + 1} of socket 1:" in told
        )
    else:
        assert len(seen.diagnostics) == many
        assert all(f"sample {begin + k + 1} of socket 1:" in told for k in range(many))


def test_samples_of_another_placement_are_told(look, record_at, placements):
    more = record_at([0.35, -0.4, 0.1], 2)
    samples = (*placements[0].samples[:33], *more.samples[33:])
    (finding,) = look([replace(placements[0], samples=samples), *placements[1:]]).diagnostics
    assert "samples 14 to 20 of socket 1 lie in socket 1 of right" in finding.text


def test_one_sample_from_elsewhere_was_not_badly_seated(look, placements, elsewhere):
    samples = list(placements[0].samples)
    samples[31] = elsewhere.samples[31]
    (finding,) = look([replace(placements[0], samples=tuple(samples)), *placements[1:]]).diagnostics
    assert finding.code == "elsewhere"
    assert finding.where.endswith("sample 12 of socket 1") and "another base" in finding.advice


def test_a_base_that_moved_amid_the_only_placement_is_no_wrong_model(look, placements):
    samples = list(placements[0].samples)
    samples[30:] = placements[2].samples[30:]
    (finding,) = look([replace(placements[0], samples=tuple(samples))]).diagnostics
    assert finding.code == "moved" and finding.where.endswith("sample 11 of socket 1")


@pytest.mark.parametrize(("moved", "seeds"), [(0.0, (1, 3)), (0.0045, (1,)), (0.012, (1, 3))])
def test_play_moves_samples_together_and_is_no_moved_base(moved, seeds):
    """Nor is a move that play makes as well; one by more is an error still, by whatever name."""
    robot = load_robot("so101")
    for seed in seeds:
        generator = np.random.default_rng(5000 + seed)
        arm = perturb(robot, generator, 3e-4, 0.0)
        (base,) = reachable_bases(arm, generator, 1)
        away = replace(base, centre=base.centre + np.array([0.0, 0.0, moved]))
        play = Imperfection(3e-4, play=0.012, resolution=1.5e-3)
        first, then = (
            record(arm, b, generator, samples=15, imperfection=play) for b in (base, away)
        )
        rows = sorted((*first.samples, *then.samples), key=lambda sample: sample.socket)
        measured = measure(replace(first, samples=tuple(rows)), robot, None)
        seen = inspect_all(robot, [measured], zeros=True)
        assert any(finding.level == "error" for finding in seen.diagnostics) == (moved > 0.005), (
            seed
        )
        if moved == 0.0045:  # nobody has said that this arm is made of servos
            found = inspect_all(robot, [measured]).diagnostics
            assert any("add --zeros" in finding.advice for finding in found)
            assert not any("add --zeros" in finding.advice for finding in seen.diagnostics)


def test_what_may_be_play_is_told_before_the_distance_of_the_sockets():
    """Zeros and play, if not spoken of, make an arm seem 5 % shorter: the distance is right."""
    robot, placements = recorded_by_servos("so101", 301, 2, 0.15)
    measured = [measure(placement, robot, 0.15) for placement in placements]
    errors = [
        finding for finding in inspect_all(robot, measured).diagnostics if finding.level == "error"
    ]
    assert errors and all("add --zeros" in finding.advice for finding in errors)
