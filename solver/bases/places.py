"""The places of several robots: of all together, and as each has them when it is fitted alone."""

from collections.abc import Sequence
from dataclasses import replace

from ..identification.data import (
    CALIPER_DEVIATION,
    WORLD,
    KnownDistance,
    Located,
    Measurement,
    Places,
    SocketAt,
    places_of,
)
from ..results import Measurements


def base_name(measured: Measurement, robots: int) -> str:
    """Return the name of a placement's base: of several robots, one place is one base."""
    return measured.name if robots == 1 else measured.placement.place


def common_places(
    robots: Sequence[Measurements],
    *,
    lengths: Sequence[KnownDistance] = (),
    sockets_at: Sequence[SocketAt] = (),
    deviation: float = CALIPER_DEVIATION,
    require_scale: bool = True,
) -> Places:
    """Return the places of several robots; equal ``Placement.place`` is one base, not moved.

    The world is the base of the first robot; those of others are frames, the last ones. Other
    arguments are those of :func:`.places_of`.
    """
    measured = list[Measurement]()
    for recordings in robots:
        measured += [
            m.called(base_name(m, len(robots))) for m in recordings.measurements
        ]
    world, *bases = (recordings.base_frame for recordings in robots)
    return places_of(
        measured,
        world=world,
        frames=bases,
        lengths=lengths,
        sockets_at=sockets_at,
        deviation=deviation,
        require_scale=require_scale,
    )


def places_alone(
    places: Places,
    robots: Sequence[Measurements],
    robot: int,
) -> tuple[Places, tuple[int, ...]]:
    """Return the places of one of several robots, and its sockets' indices among those of all.

    They have the names of its own placements; coordinates in the base of another robot are left
    out.
    """
    recordings = robots[robot]
    labels = _own_labels(recordings, len(robots))
    sockets = [k for k, label in enumerate(places.labels) if label in labels]
    part = places.at(sockets)
    names = (*places.frames, robots[0].base_frame)
    bases = {arm.base_frame for arm in robots}
    used = {m.frame for m in recordings.measurements if m.kind == "points"}
    located_in = {names[item.frame] for item in part.located}
    used |= located_in - bases
    frames = [name for name in places.frames if name in used]
    indices = {name: k for k, name in enumerate(frames)}
    indices[recordings.base_frame] = WORLD
    located: list[Located[int, int]] = []
    for item in part.located:
        name = names[item.frame]
        if name in indices:
            item = replace(item, frame=indices[name])
            located.append(item)
    places_of_robot = replace(
        part,
        labels=tuple(labels[label] for label in part.labels),
        located=tuple(located),
        frames=tuple(frames),
    )
    return places_of_robot, tuple(sockets)


def _own_labels(
    recordings: Measurements,
    robots: int,
) -> dict[tuple[str, int], tuple[str, int]]:
    """Return a robot's own label of each of its sockets, by that among so many robots."""
    labels: dict[tuple[str, int], tuple[str, int]] = {}
    for m in recordings.measurements:
        if m.kind != "sockets":
            continue
        name = base_name(m, robots)
        for socket in m.sockets:
            labels[name, socket] = (m.name, socket)
    return labels
