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
    own = robots[robot]
    label_of = {
        (base_name(m, len(robots)), socket): (m.name, socket)
        for m in own.measurements
        if m.kind == "sockets"
        for socket in m.sockets
    }
    sockets = [k for k, label in enumerate(places.labels) if label in label_of]
    part = places.at(sockets)
    names = (*places.frames, robots[0].base_frame)
    bases = {recordings.base_frame for recordings in robots}
    measured = {m.frame for m in own.measurements if m.kind == "points"}
    measured |= {names[item.frame] for item in part.located} - bases
    frames = tuple(name for name in places.frames if name in measured)
    indices = {name: k for k, name in enumerate(frames)} | {own.base_frame: WORLD}
    located = tuple(
        replace(item, frame=indices[names[item.frame]])
        for item in part.located
        if names[item.frame] in indices
    )
    labels = tuple(label_of[label] for label in part.labels)
    return replace(part, labels=labels, located=located, frames=frames), tuple(sockets)
