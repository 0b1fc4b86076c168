"""Where a socket base moved while it was recorded: a jump of the predicted centre."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..auto.noise import NU
from ..auto.posterior import Posterior
from ..data.measurements import Measurement

__all__ = ["Change", "find_changes", "split_at"]

SIGNIFICANT = 40.0
"""Of the squared jump over its variance, about 3 were it chance alone."""
SMALLEST_MOVE = 7.5e-4
"""A base that is knocked moves by more than this [m]; less may be how the arm was guided."""
SIDE = 4
"""Samples needed on each side of a change."""


@dataclass(frozen=True)
class Change:
    """A base that moved while a socket was recorded."""

    socket: int
    sample: int
    """The first sample after the move, counted from 0 in its socket."""
    jump: float
    """How far the predicted centre moved [m]."""


def find_changes(measured: Measurement, together: Posterior) -> tuple[Change, ...]:
    """Return where the running centre of a socket jumps, at most once each."""
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
    """Return how significant a jump before sample k is, and its size [m].

    Each side has its own robust centre, so that neither a far sample nor the jump itself hides it.
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
