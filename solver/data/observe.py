"""Put placements, and what is known of their sockets, together for a fit."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..robot import Robot
from .frames import FrameError
from .known import WORLD, Known, KnownDistance, KnownError, Located, SocketAt, find_socket
from .load import Load
from .measurements import Measurement
from .metrics import CALIPER_DEVIATION
from .observations import Instrument, Observations, Scene


@dataclass(frozen=True)
class RobotRecordings:
    """A robot and its placements."""

    robot: Robot
    measurements: Sequence[Measurement]
    load: Load = field(default_factory=Load)
    name: str = ""
    """Where there are several robots."""


def observe(
    measurements: Sequence[Measurement],
    robot: Robot,
    *,
    known: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    load: Load | None = None,
    tied: bool = True,
) -> Observations:
    """Put all placements of one robot and what is known of them together for a fit.

    Args:
        measurements: The placements.
        robot: The robot.
        known: Distances measured beside those between each placement's first two sockets.
        sockets_at: Measured coordinates of sockets.
        deviation: Standard deviation of the distance between a placement's first two sockets [m].
        load: What pulls at the joints; None for gravity alone, straight down.
        tied: Refuse a placement none of whose sockets has a known distance to another.

    Raises:
        KnownError: A known distance names a socket that is not there, or a socket of its own
            has no known distance to any other.
        FrameError: Coordinates of a socket that is not there.
    """
    recorded = RobotRecordings(robot, measurements, load or Load())
    scene = observe_all(
        [recorded], known=known, sockets_at=sockets_at, deviation=deviation, tied=tied
    )
    return scene.arms[0]


def observe_all(
    arms: Sequence[RobotRecordings],
    *,
    known: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    tied: bool = True,
) -> Scene:
    """Put the placements of all robots together; see :func:`observe`.

    A socket is known by its placement and number. Of several robots, placements of the same place
    (see :attr:`~mukca.recorder.dataset.Placement.place`) are the same base, not moved.
    """

    def of(m: Measurement) -> str:
        return m.name if len(arms) == 1 else m.placement.place

    every = [(of(m), m) for arm in arms for m in arm.measurements]
    seated = [(name, m) for name, m in every if m.kind == "sockets"]
    labels = list(dict.fromkeys((name, socket) for name, m in seated for socket in m.sockets))
    names = [m.frame for _, m in every if m.kind == "points"]
    own = {_base_of(arm): i for i, arm in enumerate(arms)}
    names += [one.frame for one in sockets_at if one.frame not in own]
    names += list(own)[1:]
    frames = list(dict.fromkeys(names))
    located = tuple(
        Located(
            find_socket(labels, one.socket, FrameError, f"{one.where}: "),
            WORLD if own.get(one.frame) == 0 else frames.index(one.frame),
            one.coordinates,
            one.deviation,
            one.where,
        )
        for one in sockets_at
    )
    pairs = _pairs(seated, labels, located, deviation)
    for k in known:
        a, b = (find_socket(labels, end) for end in (k.first, k.second))
        if a == b:
            raise KnownError(f"known distance from {k.first[0]}:{k.first[1]} to itself")
        pairs.append(Known(a, b, k.distance, k.deviation))
    ends = {end for pair in pairs for end in (pair.first, pair.second)}
    ends |= {one.socket for one in located}
    for name, m in seated:
        if tied and not any(labels.index((name, socket)) in ends for socket in m.sockets):
            raise KnownError(
                f"{m.placement.path or m.name}: only socket {m.sockets[0]} has samples, and no "
                "known distance ties it; record the other socket too, or give "
                f"--known {m.name}:{m.sockets[0]}-OTHER:0=DISTANCE"
            )
    shared = (tuple(labels), tuple(pairs), located, tuple(frames))
    bases = (WORLD, *(frames.index(base) for base in list(own)[1:]))
    samples = [_samples(arm, [(of(m), m) for m in arm.measurements], *shared) for arm in arms]
    return Scene(
        tuple(replace(one, base=base) for one, base in zip(samples, bases, strict=True)),
        tuple(arm.name for arm in arms),
        bases,
    )


def _base_of(arm: RobotRecordings) -> str:
    return f"{arm.name}:base" if arm.name else "base"


def _pairs(
    seated: Sequence[tuple[str, Measurement]],
    labels: Sequence[tuple[str, int]],
    located: Sequence[Located],
    deviation: float,
) -> list[Known]:
    """Return the distances between the first two sockets of each base.

    A default distance is left out where both sockets have coordinates in one frame: those tell.
    """
    frames = {one.socket: one.frame for one in located}
    pairs: dict[tuple[int, int], Known] = {}
    for name, m in seated:
        if not m.has_distance:
            continue
        a, b = (labels.index((name, socket)) for socket in m.sockets[:2])
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
    labels: tuple[tuple[str, int], ...],
    known: tuple[Known, ...],
    located: tuple[Located, ...],
    frames: tuple[str, ...],
) -> Observations:
    """Return the samples of one robot, among the sockets and frames of all."""
    places = [
        np.repeat([labels.index((name, s)) for s in m.sockets], m.counts)
        if m.kind == "sockets"
        else np.full(sum(m.counts), -1)
        for name, m in measurements
    ]
    return Observations(
        np.concatenate([m.positions for _, m in measurements]),
        np.concatenate([arm.load.torques(arm.robot, m) for _, m in measurements]),
        np.concatenate(places),
        labels,
        known,
        located,
        frames,
        _instrument(measurements, frames),
    )


def _instrument(
    measurements: Sequence[tuple[str, Measurement]], frames: Sequence[str]
) -> Instrument | None:
    if all(m.kind == "sockets" for _, m in measurements):
        return None
    rows = [(name, m, m.kind == "points") for name, m in measurements]
    return Instrument(
        np.concatenate(
            [np.full(sum(m.counts), frames.index(m.frame) if on else -1) for _, m, on in rows]
        ),
        np.concatenate([m.points if on else np.zeros((sum(m.counts), 3)) for _, m, on in rows]),
        tuple(name if on else "" for name, m, on in rows for _ in range(sum(m.counts))),
        tuple(sample.where for _, m, _ in rows for sample in m.placement.samples),
    )
