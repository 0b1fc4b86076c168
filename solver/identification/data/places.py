"""The places of recordings: sockets, the distances between them, and frames of coordinates.

Sockets are those of all bases.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from ..robot import Robot
from .frames import FrameError, FrameObservations
from .known import (
    CALIPER_DEVIATION,
    WORLD,
    Known,
    KnownDistance,
    KnownError,
    Label,
    Located,
    SocketAt,
    find_socket,
)
from .measurements import STANDARD_LOAD, Load, Measurement


@dataclass(frozen=True)
class RobotRecordings:
    """A robot and its placements."""

    robot: Robot
    measurements: Sequence[Measurement]
    load: Load = STANDARD_LOAD
    effects: Sequence[str] = ()
    """Coefficients of rare effects that its recordings show before any fit, by name."""


@dataclass(frozen=True, kw_only=True)
class Places:
    """The places of recordings: S sockets, K distances, F frames."""

    labels: tuple[Label, ...]
    """For each socket, the name of its placement and its number there."""
    known: tuple[Known[int], ...]
    """The measured distances."""
    located: tuple[Located[int, int], ...] = ()
    """The measured coordinates of sockets."""
    frames: tuple[str, ...] = ()
    """The names of the frames whose pose is unknown."""

    @property
    def socket_count(self) -> int:
        """Number of sockets in all placements."""
        return len(self.labels)

    def at(self, sockets: Sequence[int]) -> "Places":
        """Return these sockets alone, and what is known of them."""
        indices = {old: new for new, old in enumerate(sockets)}
        known = [k for k in self.known if {k.first, k.second} <= indices.keys()]
        located = [item for item in self.located if item.socket in indices]
        return Places(
            labels=tuple(self.labels[k] for k in sockets),
            known=tuple(
                replace(k, first=indices[k.first], second=indices[k.second])
                for k in known
            ),
            located=tuple(
                replace(item, socket=indices[item.socket]) for item in located
            ),
            frames=self.frames,
        )


def places_of(
    measurements: Sequence[Measurement],
    *,
    world: str = "base",
    frames: Sequence[str] = (),
    lengths: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    require_scale: bool = True,
) -> Places:
    """Return the places of recordings; placements of one name are one base, not moved.

    Args:
        measurements: The placements.
        world: Name of the frame that is the world, the robot's base.
        frames: Names of frames beside those in which something was measured, the last ones.
        lengths: Distances measured beside those between each placement's first two sockets.
        sockets_at: Measured coordinates of sockets.
        deviation: Standard deviation of the distance between a placement's first two sockets [m].
        require_scale: Refuse placements none of whose sockets has a known distance to another.
    """
    labels = list(dict.fromkeys(chain.from_iterable(m.labels for m in measurements)))
    names = [m.frame for m in measurements if m.kind == "points"]
    names += [item.frame for item in sockets_at]
    measured_in = [name for name in names if name not in (world, *frames)]
    frames = list(dict.fromkeys((*measured_in, *frames)))
    located = [_located(item, labels, frames, world) for item in sockets_at]
    pairs = _pairs(measurements, labels, located, deviation)
    pairs += [_known(length, labels) for length in lengths]
    # beside a socket that has one, others tell of the arm's shape
    if require_scale and labels and not (pairs or located):
        m = next(m for m in measurements if m.labels)
        raise KnownError(
            f"{m.placement.where}: only socket {m.sockets[0]} has samples, and no known "
            "distance ties it; record the other socket too, or give "
            f"--known {m.name}:{m.sockets[0]}-OTHER:0=DISTANCE"
        )
    return Places(
        labels=tuple(labels),
        known=tuple(pairs),
        located=tuple(located),
        frames=tuple(frames),
    )


def _located(
    item: SocketAt,
    labels: Sequence[Label],
    frames: Sequence[str],
    world: str,
) -> Located[int, int]:
    """Return measured coordinates by the indices of their frame and socket."""
    frame = WORLD if item.frame == world else frames.index(item.frame)
    socket = find_socket(labels, item.socket, FrameError, f"{item.where}: ")
    return Located(frame, socket, item.coordinates, item.deviation, item.where)


def _known(length: KnownDistance, labels: Sequence[Label]) -> Known[int]:
    """Return a known distance by the indices of its sockets, of which no socket is both."""
    a = find_socket(labels, length.first)
    b = find_socket(labels, length.second)
    if a == b:
        name, socket = length.first
        raise KnownError(f"known distance from {name}:{socket} to itself")
    return Known(a, b, length.distance, length.deviation)


def measured_in_frame(places: Places, frame: int, name: str) -> FrameObservations:
    """Return the sockets whose coordinates in a frame were measured."""
    items = [item for item in places.located if item.frame == frame]
    return FrameObservations(
        name,
        np.array([item.socket for item in items], dtype=np.int64),
        np.reshape([item.coordinates for item in items], (-1, 3)),
        [item.where for item in items],
    )


def _pairs(
    measured: Sequence[Measurement],
    labels: Sequence[Label],
    located: Sequence[Located[int, int]],
    deviation: float,
) -> list[Known[int]]:
    """Return the distances of the bases, but defaults where coordinates in one frame give them."""
    frames = {item.socket: item.frame for item in located}
    pairs: dict[tuple[int, int], Known[int]] = {}
    for m in measured:
        if not m.has_distance:
            continue
        a, b = map(labels.index, m.labels[:2])
        in_one_frame = a in frames and frames[a] == frames.get(b)
        if in_one_frame and m.distance_source in ("default", "located"):
            continue
        pair = Known(a, b, m.distance, deviation, on_base=True)
        if pairs.setdefault((a, b), pair).distance != m.distance:
            raise KnownError(
                f"{m.name}: its sockets are {pairs[a, b].distance} m apart for one robot, and "
                f"{m.distance} m for another; one base has one distance"
            )
    return list(pairs.values())
