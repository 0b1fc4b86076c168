"""The places of several robots as each of them has them when it is calibrated alone."""

from collections.abc import Sequence
from dataclasses import replace

from ..data import WORLD, Places, RobotRecordings, base_name


def places_alone(
    places: Places, robots: Sequence[RobotRecordings], robot: int
) -> tuple[Places, tuple[int, ...]]:
    """Return the places of one of several robots, and its sockets' indices among those of all.

    They have the names of its own placements; coordinates in the base of another robot are left
    out.
    """
    recordings = robots[robot]
    visited = dict[tuple[str, int], tuple[str, int]]()
    for m in recordings.measurements:
        for name, socket in m.labels:
            visited[base_name(m, len(robots)), socket] = (name, socket)
    sockets = [k for k, label in enumerate(places.labels) if label in visited]
    part = places.at(sockets)
    names = (*places.frames, robots[0].base_frame)
    others = {other.base_frame for other in robots}
    measured = {m.frame for m in recordings.measurements if m.kind == "points"}
    measured |= {names[item.frame] for item in part.located} - others
    frames = [name for name in places.frames if name in measured]
    indices = {name: k for k, name in enumerate(frames)} | {recordings.base_frame: WORLD}
    located = [item for item in part.located if names[item.frame] in indices]
    alone = replace(
        part,
        labels=tuple(visited[label] for label in part.labels),
        located=tuple(replace(item, frame=indices[names[item.frame]]) for item in located),
        frames=tuple(frames),
    )
    return alone, tuple(sockets)
