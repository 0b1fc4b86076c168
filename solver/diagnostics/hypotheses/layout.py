"""Rows of recordings: samples, seat after seat, then known distances, each with its names."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ...identification.data import Known, Measurement
from .samples import Seat, SeatSamples, samples_of, seats_of


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Samples of all placements, seat after seat, and the known distances."""

    measurements: tuple[Measurement, ...]
    known: tuple[Known[int], ...]
    """Known distances, by indices of sockets."""
    numbers: np.ndarray
    """Number of each sample in its socket, from 0; some may have been left out, shape (N,)."""
    readings: np.ndarray | None = None
    """Corrected joint positions, shape (N, m); None for those recorded."""

    @cached_property
    def samples(self) -> SeatSamples:
        """Joint positions, the seats of the balls, and what instruments measured."""
        recorded = samples_of(self.measurements)
        if self.readings is None:
            return recorded
        return replace(recorded, q=self.readings)

    @property
    def q(self) -> np.ndarray:
        """Joint positions, shape (N, m)."""
        return self.samples.q

    @property
    def sockets(self) -> np.ndarray:
        """Index of each sample's seat, shape (N,)."""
        return self.samples.sockets

    @property
    def frames(self) -> list[int]:
        """Indices of the seats that are frames of instruments."""
        return self.samples.frames

    @cached_property
    def labels(self) -> tuple[Seat, ...]:
        """Placement and number of each socket; then the frames of instruments."""
        labels, _ = seats_of(self.measurements)
        return labels

    @cached_property
    def places(self) -> tuple[slice, ...]:
        """Samples of each placement."""
        counts = [len(m.positions) for m in self.measurements]
        ends = np.cumsum([0, *counts]).tolist()
        bounds = pairwise(ends)
        return tuple(slice(first, end) for first, end in bounds)

    @property
    def ranks(self) -> tuple[np.ndarray, ...]:
        """Rank of each sample of each placement in the order of recording."""
        return tuple(m.order for m in self.measurements)

    @property
    def every(self) -> slice:
        """All samples."""
        return slice(0, len(self.q))

    @property
    def all_samples(self) -> slice:
        """The rows of all samples' residuals."""
        return self.rows(self.every)

    @property
    def all_lengths(self) -> slice:
        """The rows of the residuals of known distances."""
        first = self.all_samples.stop
        return slice(first, first + len(self.known))

    def rows(self, samples: slice) -> slice:
        """Return the rows of some samples' residuals."""
        return slice(3 * samples.start, 3 * samples.stop)

    def in_rows(self, rows: slice, columns: np.ndarray) -> np.ndarray:
        """Return columns, or a shift, of some rows as those of all residuals, (3 N + K, ...)."""
        count = self.all_lengths.stop
        full = np.zeros((count, *columns.shape[1:]))
        full[rows] = columns
        return full

    def stacked(self, parts: Sequence[tuple[slice, np.ndarray]]) -> np.ndarray:
        """Return columns of some rows each, side by side, as those of all residuals."""
        return np.hstack([self.in_rows(rows, columns) for rows, columns in parts])

    def measured(self, placement: str) -> Measurement:
        """Return a placement by its name."""
        return next(m for m in self.measurements if m.name == placement)

    def named(self, place: int) -> dict[str, str]:
        """Return the name of a placement, as a parameter of explanations."""
        return {"placement": self.measurements[place].name}

    def sample(self, place: int, row: int) -> dict[str, Any]:
        """Return placement, socket, index in it, and the numbers as recorded, of a sample.

        A point that an instrument measured has its number in the recording, too, from 1.
        """
        rank = int(self.ranks[place][row])
        first = self.places[place].start
        recorded = self.measurements[place].placement.samples[rank]
        names: dict[str, Any] = {
            **self.named(place),
            "socket": recorded.socket,
            "sample": int(self.numbers[first + row]),
            "number": recorded.number,
            "place": recorded.place,
        }
        if recorded.point is not None:
            names["point"] = rank + 1
        return names
