"""The samples of one robot, and the places where they were recorded."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import Literal

import numpy as np

from .known import CALIPER_DEVIATION, WORLD, KnownDistance, SocketAt
from .places import Places, RobotRecordings, places_of
from .samples import Samples, joined

SourceKind = Literal["sockets", "points", "turns"]
SOURCE_KINDS: tuple[SourceKind, ...] = ("sockets", "points", "turns")
"""Balls in sockets, measured balls [m], and measured orientations [rad]: each has its own noise."""


@dataclass(frozen=True, kw_only=True)
class Observations(Samples, Places):
    """The data of one robot: N samples, m joints, and the places, S sockets among them."""

    sockets: np.ndarray
    """Index of each sample's socket among all sockets, shape (N,); -1 for what an instrument
    measured."""
    recorded_at: np.ndarray
    """Name of the placement of each sample, shape (N,)."""
    measured_in: np.ndarray
    """Index of the frame in which an instrument measured each ball, shape (N,); -1 for none."""
    points: np.ndarray
    """Its coordinates in that frame, shape (N, 3) [m]; zero for a sample in a socket."""
    turned_in: np.ndarray
    """Index of the frame of each measured orientation, shape (N,); -1 for other samples."""
    rotations: np.ndarray
    """Orientations in that frame, shape (N, 3, 3)."""
    wheres: np.ndarray
    """File and line of each measured sample, for messages, shape (N,)."""

    @classmethod
    def none(cls, joints: int) -> "Observations":
        """Return no samples of a robot with so many joints."""
        nothing = Samples.unloaded(np.zeros((0, joints)))
        return cls.of(nothing, Places(labels=(), known=()))

    @classmethod
    def of(cls, samples: Samples, places: Places, name: str = "") -> "Observations":
        """Return samples of a placement, by its name, that nothing is known of but the arm."""
        N = len(samples.q)
        none = np.full(N, -1)
        return cls(
            **vars(places),
            **vars(samples),
            sockets=none,
            recorded_at=np.full(N, name),
            measured_in=none,
            points=np.zeros((N, 3)),
            turned_in=none,
            rotations=np.tile(np.eye(3), (N, 1, 1)),
            wheres=np.full(N, ""),
        )

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
        numbers = range(len(self.source_kinds))
        return tuple(np.flatnonzero(self.source_of == k) for k in numbers)

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
        return np.flatnonzero(self.seated)[
            np.argsort(self.seated_sockets, kind="stable")
        ]

    @cached_property
    def _starts(self) -> np.ndarray:
        """Where the samples of each socket begin among these, shape (S,)."""
        return np.searchsorted(self.sockets[self._order], np.arange(self.socket_count))

    @property
    def freedom(self) -> int:
        """Number of samples in sockets by which the volume counts in (A1).

        It is one less for each socket, whose centre is unknown.
        """
        return len(self.seated_sockets) - self.socket_count

    def by_socket(self, values: np.ndarray) -> np.ndarray:
        """Return the sums over the samples of each socket, shape (S, ...)."""
        return np.add.reduceat(values[self._order], self._starts, axis=0)

    @cached_property
    def in_sockets(self) -> list[np.ndarray]:
        """Indices of the samples of each socket."""
        return np.split(self._order, self._starts)[1:]

    @property
    def anchored(self) -> bool:
        """True where coordinates of sockets are known in the robot's own base."""
        return any(socket.frame == WORLD for socket in self.located)

    @cached_property
    def placements(self) -> tuple[str, ...]:
        """The names of all placements."""
        names = [name for name, _ in self.labels]
        return tuple(dict.fromkeys((*names, *self.recorded_at.tolist())))

    def points_in(self, frame: str) -> int:
        """Return how many balls were measured in a frame."""
        # The last is no frame; its index is -1.
        names = np.array((*self.frames, ""))
        return int(np.sum(names[self.measured_in] == frame))

    def rows_of(self, *placements: str) -> np.ndarray:
        """Return a mask of the places that were recorded at some placements, shape (N,)."""
        masks = [self._rows[name] for name in placements if name in self._rows]
        return reduce(np.logical_or, masks, np.zeros_like(self.turned))

    @cached_property
    def _rows(self) -> dict[str, np.ndarray]:
        """Masks of the places of each placement with samples."""
        names = np.unique(self.recorded_at).tolist()
        return {name: (self.recorded_at == name) & ~self.turned for name in names}

    def without(self, placements: Collection[str]) -> "Observations":
        """Return the observations without some placements and the distances to their sockets."""
        indices = [
            i for i, (name, _) in enumerate(self.labels) if name not in placements
        ]
        rows = ~np.isin(self.recorded_at, list(placements))
        samples = self.only(rows)
        new = np.full(self.socket_count + 1, -1)  # the last stands for no socket
        new[indices] = np.arange(len(indices))
        places = vars(self.at(indices))
        return replace(samples, sockets=new[samples.sockets], **places)


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
        arm.measurements,
        lengths=lengths,
        sockets_at=sockets_at,
        deviation=deviation,
        require_scale=require_scale,
    )
    return observations_at(places, arm)


def observations_at(places: Places, arm: RobotRecordings) -> Observations:
    """Return the samples of a robot at its places."""
    parts = list[Observations]()
    turns = [m for m in arm.measurements if m.has_orientations]
    for i, m in enumerate((*arm.measurements, *turns)):
        part = Observations.of(arm.load.samples(arm.robot, m), places, m.name)
        columns: dict[str, np.ndarray] = {"wheres": m.wheres}
        if m.kind == "sockets":
            sockets = [places.labels.index(label) for label in m.labels]
            columns["sockets"] = np.repeat(sockets, m.counts)
        else:
            frame = np.full(len(m.positions), places.frames.index(m.frame))
            if i < len(arm.measurements):
                columns |= {"measured_in": frame, "points": m.points}
            else:
                columns |= {"turned_in": frame, "rotations": m.rotations}
        parts.append(replace(part, **columns))
    return joined(parts)
