"""Finds where a socket base was moved while it was being recorded.

While the base stands still, all samples in one socket predict the same ball centre, up to noise.
If it is knocked, the predicted centre jumps, and stays there from that sample on.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..auto.noise import NU
from ..auto.posterior import Posterior
from ..data.measurements import Measurement

__all__ = ["Change", "find_changes", "split_at"]

SIGNIFICANT = 40.0
"""A jump counts if its square is this many times its variance; chance alone gives about 3."""
SMALLEST_MOVE = 7.5e-4
"""A smaller jump does not count [m]: guiding the arm differently can look like that, too."""
SIDE = 4
"""At least so many samples are needed before a jump, and after it."""


@dataclass(frozen=True)
class Change:
    """A base that moved while a socket was recorded."""

    socket: int
    sample: int
    """The first sample after the move, counted from 0 in its socket."""
    jump: float
    """How far the predicted centre moved [m]."""


def find_changes(measured: Measurement, together: Posterior) -> tuple[Change, ...]:
    """Return where the predicted centre of a socket jumps; at most one jump for each socket.

    Args:
        measured: The placement to look at.
        together: A fit to this placement and all others, which predicts the ball centres.
    """
    data = together.data
    found: list[Change] = []
    for socket in measured.sockets:
        rows = data.sockets == data.labels.index((measured.name, socket))
        points = together.points[rows]
        scores = [(*_jump(points, k), k) for k in range(SIDE, len(points) - SIDE + 1)]
        significance, jump, k = max(scores, default=(0.0, 0.0, 0))
        if significance > SIGNIFICANT and jump > SMALLEST_MOVE:
            found.append(Change(socket, k, jump))
    return tuple(found)


def _jump(points: np.ndarray, k: int) -> tuple[float, float]:
    """Return how significant a jump between samples k - 1 and k is, and its size [m].

    The samples before and after have a centre each, in which samples far off weigh little.

    Args:
        points: Predicted ball centres in the order of recording, shape (N, 3) [m].
        k: First sample after the jump.
    """
    sides = points[:k], points[k:]
    medians = [np.median(side, axis=0) for side in sides]
    squares = [np.sum((p - m) ** 2, axis=1) for p, m in zip(sides, medians, strict=True)]
    variance = float(np.median(np.concatenate(squares))) / 2.366  # the median of chi2 with 3
    weights = [1 / (NU + d / variance) for d in squares]
    centres = [np.average(p, axis=0, weights=w) for p, w in zip(sides, weights, strict=True)]
    jump = float(np.linalg.norm(centres[1] - centres[0]))
    return jump**2 / (variance * (1 / k + 1 / (len(points) - k))), jump


def split_at(measured: Measurement, changes: Sequence[Change]) -> Measurement:
    """Return a placement with the part after each change as a socket of its own."""
    placement = measured.placement
    samples = list(placement.samples)
    free = max(sample.socket for sample in samples) + 1
    for change in changes:
        rows = [i for i, s in enumerate(samples) if s.socket == change.socket][change.sample :]
        for i in rows:
            samples[i] = replace(samples[i], socket=free)
        free += 1
    return replace(measured, placement=replace(placement, samples=tuple(samples)))
