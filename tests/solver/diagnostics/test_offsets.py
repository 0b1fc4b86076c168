"""Offsets of several joints at once, with a sign or a swap among them, are told."""

import numpy as np
import pytest

EYE = np.eye(7)
RIGHT, SWAPPED = list(range(7)), [0, 1, 4, 3, 2, 5, 6]
FLIPPED = 1 - 2 * EYE[2]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "flips", "offsets", "code", "words"),
    [
        (RIGHT, 1, 0.1 * EYE[1] - 0.15 * EYE[3], "zero", "joints 2 and 4 ("),
        (RIGHT, FLIPPED, 0.1 * EYE[3], "sign", "looks sign-flipped and joint 4"),
        (SWAPPED, 1, 0.12 * EYE[1], "swap", "look swapped and joint 2"),
    ],
)
def test_two_mistakes_are_told_together(
    look, placements, change, order, flips, offsets, code, words
):
    """And before the distance: two offsets make the arm come out too large."""
    off = change(placements[0], lambda q: ((q + offsets) * flips)[order])
    (found,) = [d for d in look([off]).diagnostics if d.level == "error"]
    assert found.code == code and words in found.text, found.text
    assert found.text.count("taken off") == 1
