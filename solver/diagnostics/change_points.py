"""Bases that moved amid a placement, and placements split there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..data import Measurement


@dataclass(frozen=True)
class Change:
    """A base that moved while a socket was recorded."""

    socket: int
    sample: int
    """The first sample after the move, counted from 0 in its socket."""
    jump: float
    """Distance that the predicted centre moved [m]."""


def split_at(measured: Measurement, changes: Sequence[Change]) -> Measurement:
    """Return a placement with the samples after each change as a socket of its own."""
    placement = measured.placement
    samples = list(placement.samples)
    free = max(sample.socket for sample in samples) + 1
    rows = {
        change.socket: [i for i, s in enumerate(samples) if s.socket == change.socket]
        for change in changes
    }
    for change in changes:
        for i in rows[change.socket][change.sample :]:
            samples[i] = replace(samples[i], socket=free)
        free += 1
    return replace(measured, placement=replace(placement, samples=tuple(samples)))
