"""Zeros of several joints that are off at once, and which of them are.

Singly they are tried one by one; together they are too many to try. But the ball's centre is smooth
in them, so Gauss-Newton steps find them from a few starts: the columns as they are, with one sign
or swap mended, or with one zero that is far off.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .column_hypotheses import ColumnHypothesis
from .robust_fit import RigidModel, Samples

STEPS = 8
LARGEST_STEP = 0.2
"""Of a zero in a step [rad]."""
MOST = 3
"""Mistakes of a recording at most; a model that needs more is another robot's."""
USUAL = np.deg2rad(1.5)
"""Joints' zeros may be off by less than this."""
NEEDED = 1.5
"""The error without a zero that is off is so many times as large as with it."""


def several(
    model: RigidModel, samples: Samples, starts: Sequence[ColumnHypothesis], joints: Sequence[int]
) -> ColumnHypothesis | None:
    """Return the best guess with the zeros of some joints, none of which could be left out.

    Args:
        model: The arm.
        samples: Some of its samples.
        starts: Guesses to begin at.
        joints: Whose zeros may be off.

    Returns:
        None where too many mistakes would be needed, or none.
    """

    def error(guess: ColumnHypothesis) -> float:
        return model.nominal_error(guess.of(samples))

    best = min((_with_zeros(model, samples, start, joints) for start in starts), key=error)
    kept = list(joints)
    while kept:
        fewer = [
            _with_zeros(model, samples, _without(best, joint), [j for j in kept if j != joint])
            for joint in kept
        ]
        simpler = min(fewer, key=error)
        if error(simpler) > NEEDED * error(best):
            break
        best, kept = simpler, [j for j in kept if simpler.zeros[j]]
    zeros = np.where(np.abs(best.zeros) < USUAL, 0.0, best.zeros)
    best = replace(best, zeros=zeros)
    count = int(np.count_nonzero(zeros)) + sum(kind != "zero" for kind in best.mistakes)
    return best if 0 < count <= MOST else None


def _without(guess: ColumnHypothesis, joint: int) -> ColumnHypothesis:
    return replace(guess, zeros=np.where(np.arange(len(guess.zeros)) == joint, 0.0, guess.zeros))


def _with_zeros(
    model: RigidModel, samples: Samples, start: ColumnHypothesis, joints: Sequence[int]
) -> ColumnHypothesis:
    """Return a guess with the best zeros of some joints near those it has."""
    zeros = start.zeros.copy()
    for _ in range(STEPS if joints else 0):
        step = model.nominal_zeros(replace(start, zeros=zeros).of(samples), joints)
        zeros[list(joints)] += step * min(1.0, LARGEST_STEP / max(float(np.abs(step).max()), 1e-9))
    return replace(start, zeros=zeros)
