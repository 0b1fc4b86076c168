"""Zeros of several joints that are off at once, with a sign or a swap among them, are told."""

from dataclasses import replace

import numpy as np
import pytest

from mukca.solver.data import measure
from mukca.solver.diagnostics import inspect_all
from mukca.solver.diagnostics.column_hypotheses import several_offsets, signs, swaps, unchanged
from mukca.solver.diagnostics.robust_fit import RigidModel, Samples, samples_of
from mukca.solver.robot import choose_parameters

EYE = np.eye(7)
RIGHT, SWAPPED = list(range(7)), [0, 1, 4, 3, 2, 5, 6]
FLIPPED = 1 - 2 * EYE[2]


@pytest.fixture(scope="module")
def model(panda) -> RigidModel:
    return RigidModel(panda, choose_parameters(panda))


@pytest.fixture(scope="module")
def samples(panda, placements) -> Samples:
    return samples_of([measure(placements[0], panda)])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "flips", "zeros", "mistakes", "words"),
    [
        (RIGHT, 1, 0.1 * EYE[1] - 0.15 * EYE[3], {"zero": [1, 3]}, "joints 2 and 4 ("),
        (RIGHT, FLIPPED, 0.1 * EYE[3], {"sign": [2], "zero": [3]}, "looks sign-flipped and joint"),
        (SWAPPED, 1, 0.12 * EYE[1], {"swap": [2, 4], "zero": [1]}, "look swapped and joint 2"),
    ],
)
def test_two_mistakes_are_told_together(
    model, samples, order, flips, zeros, mistakes, words
) -> None:
    spoilt = replace(samples, positions=((samples.positions + zeros) * flips)[:, order])
    starts = [unchanged(model.robot), [*signs(model.robot, 1)][2], [*swaps(model.robot)][12]]
    guess = several_offsets(model, spoilt, starts, range(1, 6))
    assert guess is not None and guess.mistakes == mistakes
    assert guess.offsets == pytest.approx(zeros, abs=0.015)
    assert words in guess.text and guess.text.count("taken off") == 1


def test_where_nothing_is_wrong_nothing_is_found(model, samples) -> None:
    assert several_offsets(model, samples, [unchanged(model.robot)], range(1, 6)) is None


@pytest.mark.slow
def test_another_robot_s_model_is_no_set_of_zeros(model, samples) -> None:
    wild = np.random.default_rng(0).normal(0, 0.3, samples.positions.shape)
    shuffled = replace(samples, positions=samples.positions + wild)
    starts = [unchanged(model.robot), *signs(model.robot, 1)]
    guess = several_offsets(model, shuffled, starts, range(1, 6))
    assert guess is None or model.nominal_error(guess.apply(shuffled)) > 0.02


@pytest.mark.slow
def test_joints_are_named_before_the_distance(panda, placements, change) -> None:
    """Two zeros that are off make the arm come out too large, with the distance as it is."""
    off = change(placements[0], lambda q: q + 0.1 * EYE[1] - 0.15 * EYE[3])
    seen = inspect_all(panda, [measure(off, panda)])
    (finding,) = [f for f in seen.diagnostics if f.level == "error"]
    assert finding.code == "zero" and finding.text.startswith("joints 2 and 4 (")
