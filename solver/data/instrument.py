"""Balls that an instrument measured, as a laser tracker does, row by row as a fit's samples."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from .measurements import Measurement


@dataclass(frozen=True)
class Instrument:
    """The balls that an instrument measured, row by row as the samples they belong to."""

    frames: np.ndarray
    """Index of the frame of each, shape (N,); -1 for a sample in a socket."""
    points: np.ndarray
    """Coordinates in that frame, shape (N, 3) [m]; zero for a sample in a socket."""
    placements: tuple[str, ...]
    """For each sample, the name of its placement; empty for one in a socket."""
    sources: tuple[str, ...]
    """File and line of each, for messages."""

    def rows_besides(self, placements: Collection[str]) -> np.ndarray:
        """Return a mask of the measured samples but for some placements', shape (N,)."""
        left = ("", *placements)
        return np.array([name not in left for name in self.placements], dtype=bool)

    def of(self, rows: np.ndarray) -> "Instrument | None":
        """Return the balls measured at some samples; None where none was."""
        if not (self.frames[rows] >= 0).any():
            return None
        picked = np.flatnonzero(rows).tolist()
        return Instrument(
            self.frames[rows],
            self.points[rows],
            tuple(self.placements[i] for i in picked),
            tuple(self.sources[i] for i in picked),
        )


def measured_points(
    measurements: Sequence[tuple[str, Measurement]], frames: Sequence[str]
) -> Instrument | None:
    """Return the measured balls of placements, by their names; None where there is none."""
    if all(m.kind == "sockets" for _, m in measurements):
        return None
    rows = [(name, m, m.kind == "points") for name, m in measurements]
    return Instrument(
        np.concatenate(
            [np.full(sum(m.counts), frames.index(m.frame) if on else -1) for _, m, on in rows]
        ),
        np.concatenate([m.points if on else np.zeros((sum(m.counts), 3)) for _, m, on in rows]),
        tuple(name if on else "" for name, m, on in rows for _ in range(sum(m.counts))),
        tuple(sample.where for _, m, _ in rows for sample in m.placement.samples),
    )
