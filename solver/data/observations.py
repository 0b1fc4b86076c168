"""All that a fit is told: the samples of all placements, and what is known of places.

Every sample says that the ball of a robot is at a place. Places are sockets, or points that an
instrument measured. What is known of them are distances, or coordinates in a frame whose own pose
is known or not, see :mod:`.frames`.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from .known import WORLD, Known, Located, distance_covariance


@dataclass(frozen=True)
class Observations:
    """What is known of one robot: N samples, m joints, S sockets, K distances, F frames."""

    positions: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    torques: np.ndarray
    """What the joints exert to hold the arm, about their own axes and those across, shape
    (N, 3 m) [N m]."""
    sockets: np.ndarray
    """Index of each sample's socket among all sockets, shape (N,); -1 for a ball that an instrument
    measured."""
    labels: tuple[tuple[str, int], ...]
    """For each socket, the name of its placement and its number there."""
    known: tuple[Known, ...]
    """The measured distances."""
    located: tuple[Located, ...] = ()
    """The measured coordinates of sockets."""
    frames: tuple[str, ...] = ()
    """The names of the frames whose pose is unknown."""
    instrument: "Instrument | None" = None
    """What an instrument measured; None where it measured nothing."""
    base: int = WORLD
    """Index of the frame that is the robot's base."""

    @property
    def anchored(self) -> bool:
        """Whether coordinates of sockets are known in the robot's own base."""
        return any(one.frame == self.base for one in self.located)

    @property
    def socket_count(self) -> int:
        """Number of sockets in all placements."""
        return len(self.labels)

    def distance_covariance(self) -> np.ndarray:
        """Return :func:`distance_covariance` of the known distances."""
        return distance_covariance(self.known)

    def without(self, placements: Collection[str]) -> "Observations":
        """Return the observations without some placements and the distances to their sockets."""
        kept = [i for i, (name, _) in enumerate(self.labels) if name not in placements]
        new = {old: i for i, old in enumerate(kept)}
        rows = np.isin(self.sockets, kept)
        instrument = self.instrument
        if instrument is not None:
            rows |= instrument.rows_besides(placements)
            instrument = instrument.of(rows)
        return replace(
            self,
            positions=self.positions[rows],
            torques=self.torques[rows],
            sockets=np.array([new.get(s, -1) for s in self.sockets[rows].tolist()], dtype=np.int64),
            labels=tuple(self.labels[i] for i in kept),
            known=tuple(
                replace(k, first=new[k.first], second=new[k.second])
                for k in self.known
                if k.first in new and k.second in new
            ),
            located=tuple(
                replace(one, socket=new[one.socket]) for one in self.located if one.socket in new
            ),
            instrument=instrument,
        )


@dataclass(frozen=True)
class Instrument:
    """The balls that an instrument measured, row by row as the samples they belong to."""

    frames: np.ndarray
    """Index of the frame of each, shape (N,); -1 for a sample in a socket."""
    points: np.ndarray
    """Coordinates in that frame, shape (N, 3) [m]; zero for a sample in a socket."""
    placements: tuple[str, ...]
    """For each sample, the name of its placement; empty for one in a socket."""
    wheres: tuple[str, ...]
    """File and line of each, for messages."""

    def rows_besides(self, placements: Collection[str]) -> np.ndarray:
        """Return which samples were measured, but for those of some placements, shape (N,)."""
        left = ("", *placements)
        return np.array([name not in left for name in self.placements], dtype=bool)

    def of(self, rows: np.ndarray) -> "Instrument | None":
        """Return what was measured at some samples; None where nothing was."""
        if not (self.frames[rows] >= 0).any():
            return None
        picked = np.flatnonzero(rows).tolist()
        return Instrument(
            self.frames[rows],
            self.points[rows],
            tuple(self.placements[i] for i in picked),
            tuple(self.wheres[i] for i in picked),
        )


@dataclass(frozen=True)
class Scene:
    """All robots of a fit; their sockets, distances and frames are the same ones."""

    arms: tuple[Observations, ...]
    """What is known of each robot."""
    names: tuple[str, ...] = ("",)
    """Of the robots."""
    bases: tuple[int, ...] = (WORLD,)
    """For each robot, the index of the frame of its base; the first is the world."""

    @property
    def placements(self) -> tuple[str, ...]:
        """The names of all placements."""
        names = [name for name, _ in self.arms[0].labels]
        for arm in self.arms:
            names += arm.instrument.placements if arm.instrument is not None else ()
        return tuple(dict.fromkeys(name for name in names if name))

    def without(self, placements: Collection[str]) -> "Scene":
        """Return the scene without some placements, and what is known of their sockets."""
        return replace(self, arms=tuple(arm.without(placements) for arm in self.arms))
