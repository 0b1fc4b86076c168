"""The samples of one robot, and the places where they were recorded."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from operator import itemgetter
from typing import Any, Literal

import numpy as np

from .known import WORLD, KnownDistance, SocketAt
from .metrics import CALIPER_DEVIATION
from .places import Places, RobotRecordings, places_of

BY_SAMPLE = (
    *("positions", "torques", "clocks", "time", "temperature", "recorded_at"),
    *("measured_in", "points", "turned_in", "rotations", "wheres"),
)
"""Arrays of observations with a row for each sample, beside sockets."""
SourceKind = Literal["sockets", "points", "turns"]
SOURCE_KINDS: tuple[SourceKind, ...] = ("sockets", "points", "turns")
"""Balls in sockets, measured balls [m], and measured orientations [rad]: each has its own noise."""


@dataclass(frozen=True, kw_only=True)
class Observations(Places):
    """The data of one robot: N samples, m joints, and the places, S sockets among them."""

    positions: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    torques: np.ndarray
    """Moments that hold the arm, about the joints' own axes and those across, shape (N, 3 m)
    [N m]."""
    sockets: np.ndarray
    """Index of each sample's socket among all sockets, shape (N,); -1 for what an instrument
    measured."""
    clocks: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    """Index, time and temperature from the first sample of its placement on, shape (N, 3)."""
    time: np.ndarray = field(default_factory=lambda: np.empty(0))
    """Times of the samples, shape (N,) [s]; NaN where not known."""
    temperature: np.ndarray = field(default_factory=lambda: np.empty(0))
    """Temperatures, likewise."""
    recorded_at: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=str))
    """Name of the placement of each sample, shape (N,)."""
    measured_in: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """Index of the frame in which an instrument measured each ball, shape (N,); -1 for none."""
    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    """Its coordinates in that frame, shape (N, 3) [m]; zero for a sample in a socket."""
    turned_in: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """Index of the frame of each measured orientation, shape (N,); -1 for other samples."""
    rotations: np.ndarray = field(default_factory=lambda: np.empty((0, 3, 3)))
    """Orientations in that frame, shape (N, 3, 3)."""
    wheres: np.ndarray = field(default_factory=lambda: np.empty(0, dtype=str))
    """File and line of each measured sample, for messages, shape (N,)."""

    @property
    def turned(self) -> np.ndarray:
        """True for samples that are the orientation of a ball's link, shape (N,)."""
        return self.turned_in >= 0

    @cached_property
    def seated(self) -> np.ndarray:
        """True for samples that are in a socket, shape (N,)."""
        return self.sockets >= 0

    @cached_property
    def seated_sockets(self) -> np.ndarray:
        """Index of the socket of each of these."""
        return self.sockets[self.seated]

    @cached_property
    def sources(self) -> tuple[np.ndarray, ...]:
        """Samples that share one noise, those of one of :data:`SOURCE_KINDS`."""
        return tuple(np.flatnonzero(self.source_of == k) for k in range(len(self.source_kinds)))

    @cached_property
    def source_of(self) -> np.ndarray:
        """Index of each sample's source, shape (N,)."""
        return np.unique(self._kinds, return_inverse=True)[1]

    @cached_property
    def source_kinds(self) -> tuple[SourceKind, ...]:
        """The kind of each source."""
        kinds: list[int] = np.unique(self._kinds).tolist()
        return tuple(SOURCE_KINDS[k] for k in kinds)

    @property
    def _kinds(self) -> np.ndarray:
        """Number of each sample's kind, shape (N,)."""
        return (self.sockets < 0).astype(int) + self.turned

    @cached_property
    def _order(self) -> np.ndarray:
        """The samples in sockets, sorted by socket."""
        return np.flatnonzero(self.seated)[np.argsort(self.seated_sockets, kind="stable")]

    @property
    def freedom(self) -> int:
        """Number of samples in sockets by which the volume counts in (A1).

        It is one less for each socket, whose centre is unknown.
        """
        return len(self.seated_sockets) - self.socket_count

    def by_socket(self, values: np.ndarray) -> np.ndarray:
        """Return the sums over the samples of each socket, shape (S, ...)."""
        starts = np.searchsorted(self.sockets[self._order], np.arange(self.socket_count))
        return np.add.reduceat(values[self._order], starts, axis=0)

    @property
    def anchored(self) -> bool:
        """True where coordinates of sockets are known in the robot's own base."""
        return any(socket.frame == WORLD for socket in self.located)

    @property
    def placements(self) -> tuple[str, ...]:
        """The names of all placements."""
        names = [name for name, _ in self.labels]
        return tuple(dict.fromkeys((*names, *self.recorded_at.tolist())))

    def points_in(self, frame: str) -> int:
        """Return how many balls were measured in a frame."""
        names = np.array((*self.frames, ""))  # the last is no frame, which has the index -1
        return int(np.sum(names[self.measured_in] == frame))

    def rows_of(self, placement: str) -> np.ndarray:
        """Return a mask of the places that were recorded at a placement, shape (N,)."""
        return (self.recorded_at == placement) & ~self.turned

    def without(self, placements: Collection[str]) -> "Observations":
        """Return the observations without some placements and the distances to their sockets."""
        indices = [i for i, (name, _) in enumerate(self.labels) if name not in placements]
        new = {old: i for i, old in enumerate(indices)}
        rows = ~np.isin(self.recorded_at, list(placements))
        places = self.at(indices)
        return replace(
            self,
            **vars(places),
            **{name: getattr(self, name)[rows] for name in BY_SAMPLE},
            sockets=np.array([new.get(s, -1) for s in self.sockets[rows].tolist()], dtype=np.int64),
        )


def observe(
    arm: RobotRecordings,
    *,
    lengths: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    require_scale: bool = True,
) -> Observations:
    """Put the placements of a robot together; the arguments are those of :func:`places_of`."""
    places = places_of(
        [arm],
        lengths=lengths,
        sockets_at=sockets_at,
        deviation=deviation,
        require_scale=require_scale,
    )
    return observations_at(places, arm)


def observations_at(places: Places, arm: RobotRecordings) -> Observations:
    """Return the samples of a robot at its places."""
    parts: list[dict[str, np.ndarray]] = []
    turns = [m for m in arm.measurements if m.has_orientations]
    for i, m in enumerate((*arm.measurements, *turns)):
        N = len(m.positions)
        turned = i >= len(arm.measurements)
        in_socket = m.kind == "sockets"
        none = np.full(N, -1)
        frame = none if in_socket else np.full(N, places.frames.index(m.frame))
        labels = product([m.name], m.sockets) if in_socket else ()
        sockets = [places.labels.index(label) for label in labels] or [-1]
        part = {
            "positions": m.positions,
            "torques": arm.load.torques(arm.robot, m),
            "sockets": np.repeat(sockets, m.counts if in_socket else N),
            "clocks": m.clocks,
            "time": m.clock("time"),
            "temperature": m.clock("temperature"),
            "recorded_at": np.full(N, m.name),
            "measured_in": none if turned else frame,
            "points": np.zeros((N, 3)) if turned or in_socket else m.points,
            "turned_in": frame if turned else none,
            "rotations": m.rotations if turned else np.tile(np.eye(3), (N, 1, 1)),
            "wheres": np.array([sample.where for sample in m.placement.samples]),
        }
        parts.append(part)
    samples: dict[str, Any] = {
        key: np.concatenate([*map(itemgetter(key), parts)]) for key in parts[0]
    }
    return Observations(**vars(places), **samples)
