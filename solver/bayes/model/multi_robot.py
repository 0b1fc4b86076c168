"""The samples of all robots of a fit as rows of one table."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from operator import attrgetter
from typing import Literal

import numpy as np

from ... import data

Kind = Literal["sockets", "points", "turns"]
KINDS: tuple[Kind, ...] = ("sockets", "points", "turns")
"""Balls in sockets, measured balls [m], and measured orientations [rad]: each has its own noise."""
BY_SAMPLE = ("sockets", "measured_in", "points", "turned_in", "rotations", "wheres")


@dataclass(frozen=True)
class SampleRows:
    """The samples of all robots, robot after robot: N in all, in S sockets, with F frames."""

    scene: data.MultiRobotObservations

    @cached_property
    def every(self) -> data.Observations:
        """All samples as those of one robot, but for what is said of joints and times."""
        arms = self.scene.arms
        rows = {name: np.concatenate([*map(attrgetter(name), arms)]) for name in BY_SAMPLE}
        return replace(arms[0], **rows)

    @cached_property
    def own(self) -> tuple[slice, ...]:
        """For each robot, which samples are its own."""
        ends = np.cumsum([0, *(len(arm.positions) for arm in self.scene.arms)]).tolist()
        return tuple(slice(a, b) for a, b in pairwise(ends))

    @cached_property
    def seated(self) -> np.ndarray:
        """True for samples that are in a socket, shape (N,)."""
        return self.every.sockets >= 0

    @cached_property
    def sockets(self) -> np.ndarray:
        """Index of the socket of each of these."""
        return self.every.sockets[self.seated]

    @cached_property
    def sources(self) -> tuple[np.ndarray, ...]:
        """Samples that share one noise, those of a robot of one of :data:`KINDS`."""
        return tuple(np.flatnonzero(self.source_of == k) for k in range(len(self.source_kinds)))

    @cached_property
    def source_of(self) -> np.ndarray:
        """Index of each sample's source, shape (N,)."""
        return np.unique(self._kinds, return_inverse=True)[1]

    @cached_property
    def source_kinds(self) -> tuple[tuple[int, Kind], ...]:
        """For each source, the index of its robot, and its kind."""
        kinds: list[int] = np.unique(self._kinds).tolist()
        return tuple((k // 3, KINDS[k % 3]) for k in kinds)

    @property
    def _kinds(self) -> np.ndarray:
        """Number of each sample's robot and kind, shape (N,)."""
        robots = np.repeat(np.arange(len(self.own)), [rows.stop - rows.start for rows in self.own])
        return 3 * robots + (self.every.sockets < 0) + self.every.turned

    @cached_property
    def order(self) -> np.ndarray:
        """The samples in sockets, sorted by socket."""
        return np.flatnonzero(self.seated)[np.argsort(self.sockets, kind="stable")]

    def by_socket(self, values: np.ndarray) -> np.ndarray:
        """Return the sums over the samples of each socket, shape (S, ...)."""
        sockets = np.arange(self.every.socket_count)
        starts = np.searchsorted(np.sort(self.sockets), sockets)
        return np.add.reduceat(values[self.order], starts, axis=0)

    @cached_property
    def volumes(self) -> tuple[float, ...]:
        """For each robot, the number of samples in sockets by which its volume counts in (A1).

        One less for each socket, whose centre is unknown; robots share that by their samples.
        """
        arms, S = self.scene.arms, self.every.socket_count
        mine = np.array([np.bincount(a.sockets[a.sockets >= 0], minlength=S) for a in arms])
        counts = mine.sum(axis=1) - (mine / np.maximum(mine.sum(axis=0), 1)).sum(axis=1)
        return tuple(counts.tolist())

    def base(self, robot: int, poses: Sequence[data.Pose]) -> data.Pose | None:
        """Return where a robot's base stands in the world; None for the world itself."""
        frame = self.scene.bases[robot]
        return None if frame == data.WORLD else poses[frame]

    def place_frames(self, points: np.ndarray) -> tuple[data.Pose, ...]:
        """Return the poses of the frames by the nominal robots' balls, shape (N, 3) [m]."""
        if not self.every.frames and not self.every.located:
            return ()
        visits = [self._seen(i, rows, points[rows]) for i, rows in enumerate(self.own)]
        for base, visited in zip(self.scene.bases, visits, strict=True):
            data.check_base(self._measured(base, visited.name), visited)
        names = dict(enumerate(self.every.frames))
        frames = {k: self._measured(k, name) for k, name in ((data.WORLD, ""), *names.items())}
        for base, visited in zip(self.scene.bases, visits, strict=True):
            frames[base] = visited.joined(frames[base])
        return tuple(data.place_frames(list(frames.values()))[1:])

    def _seen(self, robot: int, rows: slice, points: np.ndarray) -> data.FrameObservations:
        """Return the places that a robot visited: sockets, then measured balls by their row."""
        arm, name = self.scene.arms[robot], self.scene.names[robot]
        sockets: list[int] = np.unique(arm.sockets[arm.sockets >= 0]).tolist()
        centres = [np.median(points[arm.sockets == k], axis=0) for k in sockets]
        measured = np.flatnonzero((arm.sockets < 0) & ~arm.turned)
        wheres = [f"{name}: socket {arm.labels[k][0]}:{arm.labels[k][1]}" for k in sockets]
        return data.FrameObservations(
            f"the base of {name or 'the robot'}",
            np.array([*sockets, *arm.socket_count + rows.start + measured], dtype=np.int64),
            np.concatenate([np.reshape(centres, (-1, 3)), points[measured]]),
            [*wheres, *arm.wheres[measured].tolist()],
        )

    def _measured(self, frame: int, name: str) -> data.FrameObservations:
        """Return the places whose coordinates in a frame were measured."""
        scene = self.every
        coordinates_here = [socket for socket in scene.located if socket.frame == frame]
        rows = np.flatnonzero((scene.measured_in == frame) & (frame != data.WORLD))
        coordinates = np.reshape([socket.coordinates for socket in coordinates_here], (-1, 3))
        sockets = [socket.socket for socket in coordinates_here]
        return data.FrameObservations(
            name,
            np.array([*sockets, *scene.socket_count + rows], dtype=np.int64),
            np.concatenate([coordinates, scene.points[rows]]),
            [*(socket.where for socket in coordinates_here), *scene.wheres[rows].tolist()],
        )
