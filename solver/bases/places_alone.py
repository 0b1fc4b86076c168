"""The places of several robots as each of them has them when it is calibrated alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..data import WORLD, Located, Places, RobotRecordings, base_name


@dataclass(frozen=True)
class PlacesAlone:
    """The places of one robot among those of several."""

    places: Places
    """Its own places, with the names of its placements, in its own base."""
    sockets: tuple[int, ...]
    """Index of each of its sockets among those of all robots."""


def places_alone(places: Places, robots: Sequence[RobotRecordings], robot: int) -> PlacesAlone:
    """Return the places of a robot; coordinates in the base of another one are left to the tie."""
    recordings = robots[robot]
    names, visited = dict[str, str](), set[tuple[str, int]]()
    for m in recordings.measurements:
        name = base_name(m, len(robots))
        names[name] = m.name
        visited |= {(name, socket) for socket in m.sockets if m.kind == "sockets"}
    sockets = [k for k, label in enumerate(places.labels) if label in visited]
    mine = places.at(sockets)
    points = {m.frame for m in recordings.measurements if m.kind == "points"}
    bases = {other.base_frame for other in robots}
    measured = {_frame_name(places, robots, item) for item in mine.located} - bases
    frames = [name for name in places.frames if name in points | measured]
    located = list[Located[int, int]]()
    for item in mine.located:
        name = _frame_name(places, robots, item)
        if name == recordings.base_frame:
            located.append(replace(item, frame=WORLD))
        elif name in frames:
            located.append(replace(item, frame=frames.index(name)))
    return PlacesAlone(
        replace(
            mine,
            labels=tuple((names[name], socket) for name, socket in mine.labels),
            located=tuple(located),
            frames=tuple(frames),
        ),
        tuple(sockets),
    )


def _frame_name(places: Places, robots: Sequence[RobotRecordings], item: Located[int, int]) -> str:
    """Return the name of the frame of measured coordinates."""
    return robots[0].base_frame if item.frame == WORLD else places.frames[item.frame]
