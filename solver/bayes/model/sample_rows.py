"""The samples of a fit by their sockets, and by what their noise depends on."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from ...data import (
    WORLD,
    FrameObservations,
    Observations,
    Pose,
    check_base,
    measured_in_frame,
    place_frames,
)

Kind = Literal["sockets", "points", "turns"]
KINDS: tuple[Kind, ...] = ("sockets", "points", "turns")
"""Balls in sockets, measured balls [m], and measured orientations [rad]: each has its own noise."""


@dataclass(frozen=True)
class SampleRows:
    """The N samples of a robot, in S sockets, with F frames."""

    data: Observations

    @cached_property
    def seated(self) -> np.ndarray:
        """True for samples that are in a socket, shape (N,)."""
        return self.data.sockets >= 0

    @cached_property
    def sockets(self) -> np.ndarray:
        """Index of the socket of each of these."""
        return self.data.sockets[self.seated]

    @cached_property
    def sources(self) -> tuple[np.ndarray, ...]:
        """Samples that share one noise, those of one of :data:`KINDS`."""
        return tuple(np.flatnonzero(self.source_of == k) for k in range(len(self.source_kinds)))

    @cached_property
    def source_of(self) -> np.ndarray:
        """Index of each sample's source, shape (N,)."""
        return np.unique(self._kinds, return_inverse=True)[1]

    @cached_property
    def source_kinds(self) -> tuple[Kind, ...]:
        """The kind of each source."""
        kinds: list[int] = np.unique(self._kinds).tolist()
        return tuple(KINDS[k] for k in kinds)

    @property
    def _kinds(self) -> np.ndarray:
        """Number of each sample's kind, shape (N,)."""
        return (self.data.sockets < 0).astype(int) + self.data.turned

    @cached_property
    def order(self) -> np.ndarray:
        """The samples in sockets, sorted by socket."""
        return np.flatnonzero(self.seated)[np.argsort(self.sockets, kind="stable")]

    def by_socket(self, values: np.ndarray) -> np.ndarray:
        """Return the sums over the samples of each socket, shape (S, ...)."""
        sockets = np.arange(self.data.socket_count)
        starts = np.searchsorted(np.sort(self.sockets), sockets)
        return np.add.reduceat(values[self.order], starts, axis=0)

    @property
    def freedom(self) -> int:
        """Number of samples in sockets by which the volume counts in (A1).

        It is one less for each socket, whose centre is unknown.
        """
        return len(self.sockets) - self.data.socket_count

    def place_frames(self, points: np.ndarray) -> tuple[Pose, ...]:
        """Return first poses of the frames by the nominal robot's balls, shape (N, 3) [m]."""
        data = self.data
        if not data.frames and not data.located:
            return ()
        visited, base = self._visited(points), measured_in_frame(data, WORLD, "")
        check_base(base, visited)
        frames = [self._measured(k, name) for k, name in enumerate(data.frames)]
        return tuple(place_frames([visited.joined(base), *frames])[1:])

    def _visited(self, points: np.ndarray) -> FrameObservations:
        """Return the places that the robot visited: sockets, then measured balls by their row."""
        data, sockets = self.data, range(self.data.socket_count)
        centres = [np.median(points[data.sockets == k], axis=0) for k in sockets]
        measured = np.flatnonzero(~self.seated & ~data.turned)
        wheres = [f"socket {placement}:{number}" for placement, number in data.labels]
        return FrameObservations(
            "the base of the robot",
            np.array([*sockets, *data.socket_count + measured], dtype=np.int64),
            np.concatenate([np.reshape(centres, (-1, 3)), points[measured]]),
            [*wheres, *data.wheres[measured].tolist()],
        )

    def _measured(self, frame: int, name: str) -> FrameObservations:
        """Return the places whose coordinates in a frame were measured."""
        data = self.data
        rows = np.flatnonzero(data.measured_in == frame)
        numbers, wheres = data.socket_count + rows, data.wheres[rows].tolist()
        balls = FrameObservations(name, numbers, data.points[rows], wheres)
        return measured_in_frame(data, frame, name).joined(balls)
