"""``mukca info``: what recordings hold."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from .... import recorder
from ....errors import fixed
from .. import JsonOption, TableOptions, Terminal

HALF = 0.5
"""Share of a joint's range below which the rest are turns that its readings gained or lost."""


class _InfoOptions(TableOptions, JsonOption):
    paths: Sequence[Path]
    set_distance: float | None = None


def run_info(options: _InfoOptions, terminal: Terminal) -> int:
    """Read and describe all placements."""
    folders = recorder.find_placements(options.paths)
    if options.set_distance is not None:
        for folder in folders:
            before = recorder.set_distance(folder, options.set_distance)
            if not options.json:
                change = _change(before, options.set_distance, "changed from")
                terminal.say(f"distance {change} in {folder / recorder.METADATA}")
    terminal.warn(*recorder.unread(options.paths))
    placements = [_describe(folder, options.table) for folder in folders]
    terminal.emit({"placements": placements})
    for placement in placements if not options.json else []:
        _show(placement, terminal)
    return 0


def _describe(folder: Path, table: Mapping[str, Any]) -> dict[str, Any]:
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
        facts |= dict.fromkeys(("lowest", "highest", "largest_spread"))
        facts |= {"samples": {}, "joints": list(content.joint_names)}
        return facts | {"efforts": False, "remarks": []}
    placement = recorder.read_placement(folder, **table)
    recorder.require_near(placement)
    # a line of words, such as a second header, is no sample
    rows = ~np.isnan(placement.positions).all(axis=1)
    positions = placement.positions[rows]
    for joint in np.flatnonzero(np.isnan(positions).all(axis=0)).tolist():
        raise recorder.RecordingError(
            f"{placement.first_file}: the column of joint {joint + 1} holds no number"
        )
    sockets = placement.sockets[rows].tolist()
    unnamed = (f"joint{i + 1}" for i in range(positions.shape[1]))
    spreads = [sample.spread for sample in placement.samples if sample.spread]
    units = _listed(facts["metadata"].get("units"))
    lowest, highest, turned = _ranges(positions, units)
    return facts | {
        "name": placement.name,
        "files": [str(file) for file in placement.files],
        "samples": {str(k): sockets.count(k) for k in sorted(set(sockets))},
        "kind": placement.kind,
        "joints": list(placement.joint_names or unnamed),
        "lowest": lowest,
        "highest": highest,
        "largest_spread": [max(column) for column in zip(*spreads, strict=True)]
        or None,
        "efforts": placement.efforts is not None,
        "distance": placement.distance,
        "remarks": [*recorder.distinct(placement).remarks, *turned],
    }


def _ranges(
    positions: np.ndarray, units: list[Any]
) -> tuple[list[float], list[float], list[str]]:
    """Return the least and the largest position of each joint, and a remark on whole turns."""
    rounds: list[int] = []
    ends: list[tuple[float, float]] = []
    for i, column in enumerate(positions.T):
        column = column[~np.isnan(column)]
        low = float(column.min())
        high = float(column.max())
        start, end = recorder.arc((x, x) for x in column.tolist())
        is_wider = high > low and end - start < HALF * (high - low)
        if units[i : i + 1] != ["m"] and is_wider:
            low = start
            high = end
            rounds.append(i + 1)
        ends.append((low, high))
    some = ", ".join(map(str, rounds))
    remarks = [f"joint {some}: ranges are given without whole turns"] if rounds else []
    return [low for low, _ in ends], [high for _, high in ends], remarks


def _show(facts: dict[str, Any], terminal: Terminal) -> None:
    metadata = facts["metadata"]
    samples = facts["samples"].items()
    counts = ", ".join(f"{count} in socket {socket}" for socket, count in samples)
    if facts.get("kind") == "points":
        counts = f"{facts['samples']['0']} points that an instrument measured"
    taken_back = f" ({facts['taken_back']} taken back)" if facts["taken_back"] else ""
    terminal.say(
        f"{facts['name']}: {counts or 'no sample'}{taken_back}",
        f"  robot      {metadata.get('robot', 'not recorded')}",
        f"  distance   {_length(facts['distance'])} between sockets 0 and 1",
        *(f"  changed    {_told(row)}" for row in _listed(metadata.get("changes"))),
        f"  efforts    {'recorded' if facts['efforts'] else 'not recorded'}",
        *(f"  {line}" for line in _joint_lines(facts)),
        *(f"  session    {_told(row)}" for row in _listed(metadata.get("sessions"))),
    )
    terminal.warn(*facts["remarks"])


def _listed(value: Any) -> list[Any]:
    """Return a list of the metadata, which may be written by hand, and hold anything."""
    return cast("list[Any]", value) if isinstance(value, list) else []


def _length(distance: Any) -> str:
    if isinstance(distance, int | float):
        return f"{1e3 * distance:g} mm"
    return "not recorded" if distance is None else str(distance)


def _change(before: Any, after: Any, words: str = "from") -> str:
    """Change of a distance; the same one given again is known to be measured."""
    if before == after:
        return f"of {_length(after)} as before, and measured"
    return f"{words} {_length(before)} to {_length(after)}"


def _told(row: Any) -> str:
    """Correction of a distance and its time, or a session's facts."""
    if not isinstance(row, dict):
        return str(row)
    facts = cast("dict[str, Any]", row)
    if "distance" not in facts:
        return ", ".join(f"{key} {value}" for key, value in facts.items())
    lengths = _listed(facts["distance"])
    change = ", ".join(map(_length, lengths))
    if len(lengths) == 2:
        change = _change(*lengths)
    return f"distance {change}, {facts.get('time', 'at an unknown time')}"


def _joint_lines(facts: dict[str, Any]) -> list[str]:
    """One line a joint: the range covered, in degrees, or mm for a prismatic joint."""
    names = facts["joints"]
    if not facts["samples"]:
        return []
    units = _listed(facts["metadata"].get("units"))
    spreads = facts["largest_spread"] or [0] * len(names)
    width = max(map(len, names))
    lines: list[str] = []
    for i, name in enumerate(names):
        in_metres = len(units) == len(names) and units[i] == "m"
        scale, sign = (1e3, " mm") if in_metres else (math.degrees(1), "°")
        low = fixed(scale * facts["lowest"][i], 1)
        high = fixed(scale * facts["highest"][i], 1)
        spread = f"  spread up to {scale * spreads[i]:.4f}{sign}" if spreads[i] else ""
        lines.append(f"{name:<{width}}  {low:>8}{sign} to {high:>7}{sign}{spread}")
    return lines
