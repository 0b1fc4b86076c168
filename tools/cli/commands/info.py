"""``mukca info``: show what is in recordings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from ....recorder import (
    METADATA,
    SAMPLES,
    Placement,
    find_placements,
    placement_name,
    read_keys,
    read_metadata,
    read_placement,
    read_samples,
    set_distance,
)
from .. import JsonOption, Terminal, argument, option

EXAMPLE = """example:
  mukca info data
  mukca info data/front --set-distance 0.0501"""


@dataclass(frozen=True, kw_only=True)
class Options(JsonOption):
    """Options of ``mukca info``."""

    paths: Sequence[Path] = argument("placements, or folders of them", "PATH")
    set_distance: float | None = option(
        "correct the distance between the sockets' centres first; what it was is kept",
        "M",
        between=(1e-3, 10),
    )


def run(options: Options, terminal: Terminal) -> int:
    """Read and describe all placements."""
    folders = find_placements(options.paths)
    if options.set_distance is not None:
        for folder in folders:
            before = set_distance(folder, options.set_distance)
            if not options.json:
                to = f"to {_length(options.set_distance)} in {folder / METADATA}"
                terminal.say(f"distance changed from {_length(before)} {to}")
    placements = [describe(folder) for folder in folders]
    if options.json:
        terminal.emit({"placements": placements})
        return 0
    for placement in placements:
        _show(placement, terminal)
    return 0


def describe(folder: Path) -> dict[str, Any]:
    """Return what a placement holds, in SI units."""
    content = read_samples(folder / SAMPLES) if (folder / SAMPLES).exists() else None
    facts: dict[str, Any] = {
        "name": placement_name(folder),
        "files": [str(folder / SAMPLES)],
        "samples": {},
        "taken_back": len(content.withdrawn) if content else 0,
        "joints": list(content.joint_names) if content else [],
        "lowest": None,
        "highest": None,
        "largest_spread": None,
        "efforts": False,
        "distance": read_keys(folder / METADATA).distance,
        "remarks": [],
        "metadata": read_metadata(folder / METADATA),
    }
    if content and not content.live:
        return facts
    placement = read_placement(folder)
    positions, sockets = placement.positions, placement.sockets.tolist()
    spreads = [sample.spread for sample in placement.samples if sample.spread]
    return facts | {
        "name": placement.name,
        "files": [str(file) for file in placement.files],
        "samples": {str(socket): sockets.count(socket) for socket in sorted(set(sockets))},
        "kind": "sockets" if placement.samples[0].point is None else "points",
        "joints": list(_names(placement)),
        "lowest": positions.min(axis=0).tolist(),
        "highest": positions.max(axis=0).tolist(),
        "largest_spread": [max(column) for column in zip(*spreads, strict=True)] or None,
        "efforts": placement.efforts is not None,
        "distance": placement.distance,
        "remarks": list(placement.remarks),
    }


def _names(placement: Placement) -> tuple[str, ...]:
    count = placement.positions.shape[1]
    return placement.joint_names or tuple(f"joint{i + 1}" for i in range(count))


def _show(facts: dict[str, Any], terminal: Terminal) -> None:
    metadata = facts["metadata"]
    counts = ", ".join(f"{count} in socket {socket}" for socket, count in facts["samples"].items())
    if facts.get("kind") == "points":
        counts = f"{facts['samples']['0']} points that an instrument measured"
    taken_back = f" ({facts['taken_back']} taken back)" if facts["taken_back"] else ""
    terminal.say(f"{facts['name']}: {counts or 'no sample'}{taken_back}")
    terminal.say(f"  robot      {metadata.get('robot', 'not known')}")
    terminal.say(f"  distance   {_length(facts['distance'])} between sockets 0 and 1")
    changes = metadata.get("changes")
    for change in changes if isinstance(changes, list) else []:  # pyright: ignore[reportUnknownVariableType]
        terminal.say(f"  changed    {_change(change)}")
    terminal.say(f"  efforts    {'recorded' if facts['efforts'] else 'none'}")
    for line in _joint_lines(facts):
        terminal.say(f"  {line}")
    sessions = metadata.get("sessions")
    for session in sessions if isinstance(sessions, list) else []:  # pyright: ignore[reportUnknownVariableType]
        terminal.say(f"  session    {_session(session)}")
    for remark in facts["remarks"]:
        terminal.warn(remark)


def _length(distance: Any) -> str:
    number = isinstance(distance, int | float)
    return (
        "not known" if distance is None else f"{1e3 * distance:g} mm" if number else f"{distance}"
    )


def _change(change: Any) -> str:
    """Correction and its time; metadata may be written by hand, and hold anything."""
    if not (isinstance(change, dict) and "distance" in change):
        return str(change)  # pyright: ignore[reportUnknownArgumentType]
    known = cast("dict[str, Any]", change)
    lengths = known["distance"]
    changed = " to ".join(
        map(_length, cast("list[Any]", lengths) if isinstance(lengths, list) else [])
    )
    return f"distance from {changed}, {known.get('time', 'at an unknown time')}"


def _joint_lines(facts: dict[str, Any]) -> list[str]:
    """One line a joint: the range covered, in degrees, or mm for a prismatic joint."""
    if not facts["samples"]:
        return []
    count = len(facts["joints"])
    units: Any = facts["metadata"].get("units")
    known: list[Any] = units if isinstance(units, list) and len(units) == count else [None] * count  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    spreads = facts["largest_spread"] or [None] * count
    rows = zip(facts["joints"], known, facts["lowest"], facts["highest"], spreads, strict=True)
    width = max(map(len, facts["joints"]))
    lines: list[str] = []
    for name, unit, lowest, highest, spread in rows:
        scale, sign = (1e3, " mm") if unit == "m" else (math.degrees(1), "°")
        line = f"{name:<{width}}  {scale * lowest:8.1f}{sign} to {scale * highest:7.1f}{sign}"
        lines.append(line + (f"  spread up to {scale * spread:.4f}{sign}" if spread else ""))
    return lines


def _session(session: Any) -> str:
    if not isinstance(session, dict):
        return str(session)
    pairs: list[str] = [f"{key} {value}" for key, value in session.items()]  # pyright: ignore[reportUnknownVariableType]
    return ", ".join(pairs)
