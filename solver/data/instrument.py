"""Measurements of an instrument, as a laser tracker, row by row as the samples of a fit.

A measured pose is two samples of a fit, the ball's place [m] and its link's orientation [rad], each
an error vector with its own noise. Orientations are the last samples.
"""

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
    turned_in: np.ndarray
    """Index of the frame of each orientation, shape (N,); -1 for a sample that is none."""
    rotations: np.ndarray
    """Orientations in that frame, shape (N, 3, 3)."""

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
            self.turned_in[rows],
            self.rotations[rows],
        )


def measured_points(
    measurements: Sequence[tuple[str, Measurement]], frames: Sequence[str]
) -> Instrument | None:
    """Return what was measured at placements, by their names; None where nothing was."""
    if all(m.kind == "sockets" for _, m in measurements):
        return None
    turned = [(name, m) for name, m in measurements if m.has_orientations]
    pairs = [
        (name, m, sample) for name, m in (*measurements, *turned) for sample in m.placement.samples
    ]
    count, n = sum(len(m.placement.samples) for _, m in measurements), len(pairs)
    frames_of = [frames.index(m.frame) if m.kind == "points" else -1 for _, m, _ in pairs]
    points, rotations = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
    points[:count] = [sample.point or (0, 0, 0) for _, _, sample in pairs[:count]]
    if turned:
        rotations[count:] = np.concatenate([m.rotations for _, m in turned])
    return Instrument(
        np.array([*frames_of[:count], *[-1] * (n - count)]),
        points,
        tuple(name if m.kind == "points" else "" for name, m, _ in pairs),
        tuple(sample.where for _, _, sample in pairs),
        np.array([*[-1] * count, *frames_of[count:]]),
        rotations,
    )
