"""The data of a fit: the samples of all placements, and what was measured of places.

Places are sockets or measured points; measured are distances, or coordinates in :mod:`.frames`.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, product
from operator import itemgetter
from typing import Any

import numpy as np

from ..robot import Robot
from .frames import FrameError
from .known import (
    WORLD,
    Known,
    KnownDistance,
    KnownError,
    Located,
    SocketAt,
    find_socket,
)
from .measurements import STANDARD_LOAD, Load, Measurement
from .metrics import CALIPER_DEVIATION

BY_SAMPLE = (
    *("positions", "torques", "clocks", "time", "temperature", "recorded_at"),
    *("measured_in", "points", "turned_in", "rotations", "wheres"),
)
"""Arrays of observations with a row for each sample, beside sockets."""


@dataclass(frozen=True)
class Observations:
    """The data of one robot: N samples, m joints, S sockets, K distances, F frames."""

    positions: np.ndarray
    """Joint positions, shape (N, m) [rad]."""
    torques: np.ndarray
    """Moments that hold the arm, about the joints' own axes and those across, shape (N, 3 m)
    [N m]."""
    sockets: np.ndarray
    """Index of each sample's socket among all sockets, shape (N,); -1 for what an instrument
    measured."""
    labels: tuple[tuple[str, int], ...]
    """For each socket, the name of its placement and its number there."""
    known: tuple[Known[int], ...]
    """The measured distances."""
    located: tuple[Located[int, int], ...] = ()
    """The measured coordinates of sockets."""
    frames: tuple[str, ...] = ()
    """The names of the frames whose pose is unknown."""
    base: int = WORLD
    """Index of the frame that is the robot's base."""
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

    @property
    def anchored(self) -> bool:
        """True where coordinates of sockets are known in the robot's own base."""
        return any(socket.frame == self.base for socket in self.located)

    @property
    def socket_count(self) -> int:
        """Number of sockets in all placements."""
        return len(self.labels)

    def rows_of(self, placement: str) -> np.ndarray:
        """Return a mask of the places that were recorded at a placement, shape (N,)."""
        return (self.recorded_at == placement) & ~self.turned

    def without(self, placements: Collection[str]) -> "Observations":
        """Return the observations without some placements and the distances to their sockets."""
        indices = [i for i, (name, _) in enumerate(self.labels) if name not in placements]
        new = {old: i for i, old in enumerate(indices)}
        rows = ~np.isin(self.recorded_at, list(placements))
        return replace(
            self,
            **{name: getattr(self, name)[rows] for name in BY_SAMPLE},
            sockets=np.array([new.get(s, -1) for s in self.sockets[rows].tolist()], dtype=np.int64),
            labels=tuple(self.labels[i] for i in indices),
            known=tuple(
                replace(k, first=new[k.first], second=new[k.second])
                for k in self.known
                if k.first in new and k.second in new
            ),
            located=tuple(
                replace(item, socket=new[item.socket])
                for item in self.located
                if item.socket in new
            ),
        )


@dataclass(frozen=True)
class MultiRobotObservations:
    """All robots of a fit; their sockets, distances and frames are the same ones."""

    arms: tuple[Observations, ...]
    """The observations of each robot."""
    names: tuple[str, ...] = ("",)
    """Of the robots."""
    bases: tuple[int, ...] = (WORLD,)
    """For each robot, the index of the frame of its base; the first is the world."""

    @property
    def placements(self) -> tuple[str, ...]:
        """The names of all placements."""
        names = [name for name, _ in self.arms[0].labels]
        for arm in self.arms:
            names += arm.recorded_at.tolist()
        return tuple(dict.fromkeys(names))

    def without(self, placements: Collection[str]) -> "MultiRobotObservations":
        """Return all but some placements and what is known of their sockets."""
        return replace(self, arms=tuple(arm.without(placements) for arm in self.arms))


@dataclass(frozen=True)
class RobotRecordings:
    """A robot and its placements."""

    robot: Robot
    measurements: Sequence[Measurement]
    load: Load = STANDARD_LOAD
    name: str = ""
    """Its name among several robots."""


def base_name(measured: Measurement, robots: int) -> str:
    """Return the name of a placement's base: of several robots, one place is one base."""
    return measured.name if robots == 1 else measured.placement.place


def observe_all(
    arms: Sequence[RobotRecordings],
    *,
    lengths: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    require_scale: bool = True,
) -> MultiRobotObservations:
    """Put the placements of all robots together; equal ``Placement.place`` is one base, not moved.

    Args:
        arms: The robots and their placements.
        lengths: Distances measured beside those between each placement's first two sockets.
        sockets_at: Measured coordinates of sockets.
        deviation: Standard deviation of the distance between a placement's first two sockets [m].
        require_scale: Refuse a placement none of whose sockets has a known distance to another.
    """
    base_of = partial(base_name, robots=len(arms))
    measurements = chain.from_iterable(arm.measurements for arm in arms)
    rows = [(base_of(m), m) for m in measurements]
    in_sockets = [row for row in rows if row[1].kind == "sockets"]
    pairs_of = (product([name], m.sockets) for name, m in in_sockets)
    labels = list(dict.fromkeys(chain.from_iterable(pairs_of)))
    names = [m.frame for _, m in rows if m.kind == "points"]
    base_index = {f"{arm.name}:base" if arm.name else "base": i for i, arm in enumerate(arms)}
    names += [socket.frame for socket in sockets_at if socket.frame not in base_index]
    names += list(base_index)[1:]
    frames = list(dict.fromkeys(names))
    coordinates = tuple(
        Located(
            WORLD if base_index.get(item.frame) == 0 else frames.index(item.frame),
            find_socket(labels, item.socket, FrameError, f"{item.where}: "),
            item.coordinates,
            item.deviation,
            item.where,
        )
        for item in sockets_at
    )
    pairs = _pairs(in_sockets, labels, coordinates, deviation)
    for k in lengths:
        a = find_socket(labels, k.first)
        b = find_socket(labels, k.second)
        if a == b:
            raise KnownError(f"known distance from {k.first[0]}:{k.first[1]} to itself")
        pairs.append(Known(a, b, k.distance, k.deviation))
    if require_scale:
        _check_scale(in_sockets, labels, pairs, coordinates)
    bases = (WORLD, *(frames.index(base) for base in list(base_index)[1:]))
    observations = (
        Observations(
            **_samples(arm, [(base_of(m), m) for m in arm.measurements], labels, frames),
            labels=tuple(labels),
            known=tuple(pairs),
            located=coordinates,
            frames=tuple(frames),
            base=base,
        )
        for arm, base in zip(arms, bases, strict=True)
    )
    return MultiRobotObservations(tuple(observations), tuple(arm.name for arm in arms), bases)


def _check_scale(
    in_sockets: Sequence[tuple[str, Measurement]],
    labels: Sequence[tuple[str, int]],
    pairs: Sequence[Known[int]],
    coordinates: Sequence[Located[int, int]],
) -> None:
    """Refuse placements none of whose sockets has a known distance or coordinates.

    Beside one that has, a placement without tells of the arm's shape, as one with only one socket.
    """
    ends = set(chain.from_iterable((pair.first, pair.second) for pair in pairs))
    ends |= {item.socket for item in coordinates}
    sockets = chain.from_iterable(product([name], m.sockets) for name, m in in_sockets)
    if in_sockets and ends.isdisjoint(map(labels.index, sockets)):
        _, m = in_sockets[0]
        raise KnownError(
            f"{m.placement.path or m.name}: only socket {m.sockets[0]} has samples, and no "
            "known distance ties it; record the other socket too, or give "
            f"--known {m.name}:{m.sockets[0]}-OTHER:0=DISTANCE"
        )


def _pairs(
    in_sockets: Sequence[tuple[str, Measurement]],
    labels: Sequence[tuple[str, int]],
    coordinates: Sequence[Located[int, int]],
    deviation: float,
) -> list[Known[int]]:
    """Return the distances of the bases, but defaults where coordinates in one frame give them."""
    frames = {item.socket: item.frame for item in coordinates}
    pairs: dict[tuple[int, int], Known[int]] = {}
    for name, m in in_sockets:
        if not m.has_distance:
            continue
        a, b = [labels.index((name, socket)) for socket in m.sockets[:2]]
        in_one_frame = a in frames and frames[a] == frames.get(b)
        if in_one_frame and m.distance_source in ("default", "located"):
            continue
        pair = Known(a, b, m.distance, deviation, on_base=True)
        if pairs.setdefault((a, b), pair).distance != m.distance:
            raise KnownError(
                f"{name}: its sockets are {pairs[a, b].distance} m apart for one robot, and "
                f"{m.distance} m for another; one base has one distance"
            )
    return list(pairs.values())


def _samples(
    arm: RobotRecordings,
    measurements: Sequence[tuple[str, Measurement]],
    labels: Sequence[tuple[str, int]],
    frames: Sequence[str],
) -> dict[str, Any]:
    """Return the arrays by sample of one robot, among the sockets and frames of all."""
    parts: list[dict[str, np.ndarray]] = []
    turns = [(name, m) for name, m in measurements if m.has_orientations]
    for i, (name, m) in enumerate((*measurements, *turns)):
        N, turned, in_socket = len(m.positions), i >= len(measurements), m.kind == "sockets"
        none = np.full(N, -1)
        frame = none if in_socket else np.full(N, frames.index(m.frame))
        sockets = [labels.index((name, socket)) for socket in m.sockets] if in_socket else [-1]
        part = {
            "positions": m.positions,
            "torques": arm.load.torques(arm.robot, m),
            "sockets": np.repeat(sockets, m.counts if in_socket else N),
            "clocks": m.clocks,
            "time": m.clock("time"),
            "temperature": m.clock("temperature"),
            "recorded_at": np.full(N, name),
            "measured_in": none if turned else frame,
            "points": np.zeros((N, 3)) if turned or in_socket else m.points,
            "turned_in": frame if turned else none,
            "rotations": m.rotations if turned else np.tile(np.eye(3), (N, 1, 1)),
            "wheres": np.array([sample.where for sample in m.placement.samples]),
        }
        parts.append(part)
    return {key: np.concatenate([*map(itemgetter(key), parts)]) for key in parts[0]}
