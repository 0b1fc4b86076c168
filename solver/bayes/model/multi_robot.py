"""The samples of all robots of a fit as rows of one table."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np

from ... import data

Kind = Literal["sockets", "points", "turns"]
KINDS: tuple[Kind, ...] = ("sockets", "points", "turns")
"""Balls in sockets, measured balls [m], and measured orientations [rad]: each has its own noise."""


@dataclass(frozen=True)
class SampleRows:
    """The samples of all robots, robot after robot: N in all, in S sockets, with F frames."""

    scene: data.MultiRobotObservations

    @cached_property
    def own(self) -> tuple[slice, ...]:
        """For each robot, which samples are its own."""
        ends = np.cumsum([0, *(len(arm.positions) for arm in self.scene.arms)]).tolist()
        return tuple(slice(a, b) for a, b in pairwise(ends))

    @cached_property
    def sockets(self) -> np.ndarray:
        """Index of each sample's socket, shape (N,); -1 for a ball that was measured."""
        return np.concatenate([arm.sockets for arm in self.scene.arms])

    @cached_property
    def seated(self) -> slice | np.ndarray:
        """Samples that are in a socket."""
        return slice(None) if (self.sockets >= 0).all() else self.sockets >= 0

    @cached_property
    def measured_in(self) -> np.ndarray:
        """Index of the frame in which each ball was measured, shape (N,); -1 for none."""
        return np.concatenate([arm.measured_in for arm in self.scene.arms])

    @cached_property
    def points(self) -> np.ndarray:
        """Measured position of each ball in that frame, shape (N, 3) [m]."""
        return np.concatenate([arm.points for arm in self.scene.arms])

    @cached_property
    def turned_in(self) -> np.ndarray:
        """Index of the frame of each measured orientation, shape (N,); -1 for no orientation."""
        return np.concatenate([arm.turned_in for arm in self.scene.arms])

    @cached_property
    def turned(self) -> np.ndarray:
        """True for samples that are an orientation, shape (N,)."""
        return self.turned_in >= 0

    @cached_property
    def rotations(self) -> np.ndarray:
        """Measured orientations in that frame, shape (N, 3, 3)."""
        return np.concatenate([arm.rotations for arm in self.scene.arms])

    @cached_property
    def sources(self) -> tuple[np.ndarray | slice, ...]:
        """Samples that share one noise, those of a robot of one of :data:`KINDS`."""
        _, counts = np.unique(self._kinds, return_counts=True)
        if len(counts) == 1:
            return (slice(None),)
        return tuple(np.flatnonzero(self._kinds == kind) for kind in np.unique(self._kinds))

    @cached_property
    def source_of(self) -> np.ndarray:
        """Index of each sample's source, shape (N,)."""
        return np.unique(self._kinds, return_inverse=True)[1]

    @cached_property
    def source_kinds(self) -> tuple[tuple[int, Kind], ...]:
        """For each source, the index of its robot, and its kind."""
        kinds: list[int] = np.unique(self._kinds).tolist()
        return tuple((k // 3, KINDS[k % 3]) for k in kinds)

    @cached_property
    def _kinds(self) -> np.ndarray:
        """Number of each sample's robot and kind, shape (N,)."""
        parts = [
            3 * i + (arm.sockets < 0) + arm.turned.astype(np.int64)
            for i, arm in enumerate(self.scene.arms)
        ]
        return np.concatenate(parts)

    @cached_property
    def order(self) -> np.ndarray | slice:
        """The samples in sockets, sorted by socket."""
        seated = np.flatnonzero(self.sockets >= 0)
        if len(seated) == len(self.sockets) and (np.diff(self.sockets) >= 0).all():
            return slice(None)
        return seated[np.argsort(self.sockets[seated], kind="stable")]

    def by_socket(self, values: np.ndarray) -> np.ndarray:
        """Return the sums over the samples of each socket, shape (S, ...)."""
        starts = np.searchsorted(self.sockets[self.order], np.arange(self.socket_count))
        return np.add.reduceat(values[self.order], starts, axis=0)

    @property
    def socket_count(self) -> int:
        """Number S of sockets."""
        return self._first.socket_count

    @property
    def frame_count(self) -> int:
        """Number F of frames whose pose is unknown."""
        return len(self._first.frames)

    @property
    def located(self) -> tuple[data.Located[int, int], ...]:
        """The measured coordinates of sockets."""
        return self._first.located

    @property
    def _first(self) -> data.Observations:
        return self.scene.arms[0]

    @cached_property
    def volumes(self) -> tuple[float, ...]:
        """For each robot, the number of samples in sockets by which its volume counts in (A1).

        One less for each socket, whose centre is unknown; robots share that by their samples.
        """
        seated = self.sockets >= 0
        total = np.bincount(self.sockets[seated], minlength=self.socket_count)
        counts: list[float] = []
        for rows in self.own:
            sockets = self.sockets[rows]
            mine = np.bincount(sockets[sockets >= 0], minlength=self.socket_count)
            counts.append(float(mine.sum() - (mine / np.maximum(total, 1)).sum()))
        return tuple(counts)

    def base(self, robot: int, poses: Sequence[data.Pose]) -> data.Pose | None:
        """Return where a robot's base stands in the world; None for the world itself."""
        frame = self.scene.bases[robot]
        return None if frame == data.WORLD else poses[frame]

    def place_frames(self, points: np.ndarray) -> tuple[data.Pose, ...]:
        """Return the poses of the frames by the nominal robots' balls, shape (N, 3) [m]."""
        if not self.frame_count and not self.located:
            return ()
        visits = [self._seen(i, rows, points[rows]) for i, rows in enumerate(self.own)]
        for base, visited in zip(self.scene.bases, visits, strict=True):
            data.check_base(self._measured(base, visited.name), visited)
        names = dict(enumerate(self._first.frames))
        frames = {k: self._measured(k, name) for k, name in ((data.WORLD, ""), *names.items())}
        for base, visited in zip(self.scene.bases, visits, strict=True):
            frames[base] = visited.joined(frames[base])
        return tuple(data.place_frames(list(frames.values()))[1:])

    def _seen(self, robot: int, rows: slice, points: np.ndarray) -> data.FrameObservations:
        """Return the places that a robot visited: sockets, then measured balls by their row."""
        sockets, S = self.sockets[rows], self.socket_count
        there = np.unique(sockets[sockets >= 0])
        centres = [np.median(points[sockets == k], axis=0) for k in there.tolist()]
        measured = np.flatnonzero((sockets < 0) & (self.turned_in[rows] < 0))
        name = self.scene.names[robot]
        labels = self._first.labels
        wheres = [f"{name}: socket {labels[k][0]}:{labels[k][1]}" for k in there.tolist()]
        return data.FrameObservations(
            f"the base of {name or 'the robot'}",
            np.concatenate([there, S + rows.start + measured]).astype(np.int64),
            np.concatenate([np.reshape(centres, (-1, 3)), points[measured]]),
            [*wheres, *self._wheres(rows.start + measured)],
        )

    def _measured(self, frame: int, name: str) -> data.FrameObservations:
        """Return the places whose coordinates in a frame were measured."""
        located = [one for one in self.located if one.frame == frame]
        rows = np.flatnonzero((self.measured_in == frame) & (frame != data.WORLD))
        coordinates = np.reshape([one.coordinates for one in located], (-1, 3))
        return data.FrameObservations(
            name,
            np.concatenate([[one.socket for one in located], self.socket_count + rows]).astype(
                np.int64
            ),
            np.concatenate([coordinates, self.points[rows]]),
            [*(one.where for one in located), *self._wheres(rows)],
        )

    def _wheres(self, rows: np.ndarray) -> list[str]:
        """Return where some measured balls were read."""
        wheres: list[str] = np.concatenate([arm.wheres for arm in self.scene.arms])[rows].tolist()
        return wheres
