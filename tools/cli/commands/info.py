"""``mukca info``: show what is in recordings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from .... import recorder
from .. import JsonOption, Terminal, argument, option


@dataclass(frozen=True, kw_only=True)
class Options(JsonOption):
    """Options of ``mukca info``."""

    paths: Sequence[Path] = argument("placements, or folders of them", "PATH")
    set_distance: float | None = option(
        "correct the distance between the sockets' centres first; what it was is kept",
        "M",
        between=(1e-3, 10),
    )


def run_info(options: Options, terminal: Terminal) -> int:
    """Read and describe all placements."""
    folders = recorder.find_placements(options.paths)
    if options.set_distance is not None:
        for folder in folders:
            before = recorder.set_distance(folder, options.set_distance)
            if not options.json:
                to = f"to {_length(options.set_distance)} in {folder / recorder.METADATA}"
                terminal.say(f"distance changed from {_length(before)} {to}")
    placements = [describe(folder) for folder in folders]
    terminal.emit({"placements": placements})
    for placement in placements if not options.json else []:
        _show(placement, terminal)
    return 0


def describe(folder: Path) -> dict[str, Any]:
    """Return what a placement holds, in SI units."""
    samples = folder / recorder.SAMPLES
    content = recorder.read_samples(samples) if samples.exists() else None
    facts: dict[str, Any] = {
        "name": recorder.placement_name(folder),
        "files": [str(samples)],
        "taken_back": len(content.withdrawn) if content else 0,
        "distance": recorder.read_keys(folder / recorder.METADATA).distance,
        "metadata": recorder.read_metadata(folder / recorder.METADATA),
    }
    if content and not content.live:
        nothing = dict.fromkeys(("lowest", "highest", "largest_spread"))
        joints = list(content.joint_names)
        return facts | nothing | {"samples": {}, "joints": joints, "efforts": False, "remarks": []}
    placement = recorder.read_placement(folder)
    positions, sockets = placement.positions, placement.sockets.tolist()
    unnamed = (f"joint{i + 1}" for i in range(positions.shape[1]))
    spreads = [sample.spread for sample in placement.samples if sample.spread]
    return facts | {
        "name": placement.name,
        "files": [str(file) for file in placement.files],
        "samples": {str(socket): sockets.count(socket) for socket in sorted(set(sockets))},
        "kind": "sockets" if placement.samples[0].point is None else "points",
        "joints": list(placement.joint_names or unnamed),
        "lowest": positions.min(axis=0).tolist(),
        "highest": positions.max(axis=0).tolist(),
        "largest_spread": [max(column) for column in zip(*spreads, strict=True)] or None,
        "efforts": placement.efforts is not None,
        "distance": placement.distance,
        "remarks": list(placement.remarks),
    }


def _show(facts: dict[str, Any], terminal: Terminal) -> None:
    metadata = facts["metadata"]
    counts = ", ".join(f"{count} in socket {socket}" for socket, count in facts["samples"].items())
    if facts.get("kind") == "points":
        counts = f"{facts['samples']['0']} points that an instrument measured"
    taken_back = f" ({facts['taken_back']} taken back)" if facts["taken_back"] else ""
    terminal.say(
        f"{facts['name']}: {counts or 'no sample'}{taken_back}",
        f"  robot      {metadata.get('robot', 'not known')}",
        f"  distance   {_length(facts['distance'])} between sockets 0 and 1",
        *(f"  changed    {_told(change)}" for change in _listed(metadata.get("changes"))),
        f"  efforts    {'recorded' if facts['efforts'] else 'none'}",
        *(f"  {line}" for line in _joint_lines(facts)),
        *(f"  session    {_told(session)}" for session in _listed(metadata.get("sessions"))),
    )
    terminal.warn(*facts["remarks"])


def _listed(value: Any) -> list[Any]:
    """Return a list of the metadata, which may be written by hand, and hold anything."""
    return cast("list[Any]", value) if isinstance(value, list) else []


def _length(distance: Any) -> str:
    if isinstance(distance, int | float):
        return f"{1e3 * distance:g} mm"
    return "not known" if distance is None else str(distance)


def _told(row: Any) -> str:
    """Correction of a distance and its time, or a session's facts."""
    if not isinstance(row, dict):
        return str(row)
    known = cast("dict[str, Any]", row)
    if "distance" not in known:
        return ", ".join(f"{key} {value}" for key, value in known.items())
    changed = " to ".join(map(_length, _listed(known["distance"])))
    return f"distance from {changed}, {known.get('time', 'at an unknown time')}"


def _joint_lines(facts: dict[str, Any]) -> list[str]:
    """One line a joint: the range covered, in degrees, or mm for a prismatic joint."""
    if not facts["samples"]:
        return []
    count = len(facts["joints"])
    units = _listed(facts["metadata"].get("units"))
    known = units if len(units) == count else [""] * count
    spreads = facts["largest_spread"] or [None] * count
    rows = zip(facts["joints"], known, facts["lowest"], facts["highest"], spreads, strict=True)
    width = max(map(len, facts["joints"]))
    lines: list[str] = []
    for name, unit, lowest, highest, spread in rows:
        scale, sign = (1e3, " mm") if unit == "m" else (math.degrees(1), "°")
        line = f"{name:<{width}}  {scale * lowest:8.1f}{sign} to {scale * highest:7.1f}{sign}"
        lines.append(line + (f"  spread up to {scale * spread:.4f}{sign}" if spread else ""))
    return lines
