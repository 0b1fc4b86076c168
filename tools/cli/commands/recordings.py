"""``mukca info`` and ``convert``: what recordings hold; the other form, or columns that users name.

``q=joint_1..6 [deg]`` takes six columns, ``x=x_t+x_dif [mm]`` a sum of two.
"""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np

from .... import recorder
from ....recorder import Placement, read_table
from ....solver.calibration import UsageError
from ....solver.results import OutputError, refuse_existing, write_files
from .. import POSITIVE, JsonOption, Options, Terminal, argument, option


class _InfoOptions(JsonOption):
    paths: Sequence[Path] = argument("placements, or folders of them", "PATH")
    set_distance: float | None = option(
        None,
        "correct the distance between the sockets' centres first; what it was is kept",
        "M",
        between=(1e-3, 10),
    )


def run_info(options: _InfoOptions, terminal: Terminal) -> int:
    """Read and describe all placements."""
    folders = recorder.find_placements(options.paths)
    if options.set_distance is not None:
        for folder in folders:
            before = recorder.set_distance(folder, options.set_distance)
            if not options.json:
                change = _change(before, options.set_distance, "changed from")
                terminal.say(f"distance {change} in {folder / recorder.METADATA}")
    placements = [_describe(folder) for folder in folders]
    terminal.emit({"placements": placements})
    for placement in placements if not options.json else []:
        _show(placement, terminal)
    return 0


def _describe(folder: Path) -> dict[str, Any]:
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
        return (
            facts
            | nothing
            | {"samples": {}, "joints": joints, "efforts": False, "remarks": []}
        )
    placement = recorder.read_placement(folder)
    positions = placement.positions
    sockets = placement.sockets.tolist()
    unnamed = (f"joint{i + 1}" for i in range(positions.shape[1]))
    spreads = [sample.spread for sample in placement.samples if sample.spread]
    lowest, highest, turned = _ranges(
        positions, _listed(facts["metadata"].get("units"))
    )
    return facts | {
        "name": placement.name,
        "files": [str(file) for file in placement.files],
        "samples": {
            str(socket): sockets.count(socket) for socket in sorted(set(sockets))
        },
        "kind": placement.kind,
        "joints": list(placement.joint_names or unnamed),
        "lowest": lowest,
        "highest": highest,
        "largest_spread": [max(column) for column in zip(*spreads, strict=True)]
        or None,
        "efforts": placement.efforts is not None,
        "distance": placement.distance,
        "remarks": [*placement.distinct().remarks, *turned],
    }


def _ranges(
    positions: np.ndarray, units: list[Any]
) -> tuple[list[float], list[float], list[str]]:
    """Return the least and the largest position of each joint, and a remark on whole turns."""
    rounds: list[int] = []
    ends: list[tuple[float, float]] = []
    for i, column in enumerate(np.nan_to_num(positions).T):
        low = float(column.min())
        high = float(column.max())
        start, end = recorder.arc((x, x) for x in column.tolist())
        if units[i : i + 1] != ["m"] and end - start < HALF * (high - low):
            low = start
            high = end
            rounds.append(i + 1)
        ends.append((low, high))
    some = ", ".join(map(str, rounds))
    remarks = [f"joint {some}: ranges are given without whole turns"] if rounds else []
    return [low for low, _ in ends], [high for _, high in ends], remarks


def _show(facts: dict[str, Any], terminal: Terminal) -> None:
    metadata = facts["metadata"]
    counts = ", ".join(
        f"{count} in socket {socket}" for socket, count in facts["samples"].items()
    )
    if facts.get("kind") == "points":
        counts = f"{facts['samples']['0']} points that an instrument measured"
    taken_back = f" ({facts['taken_back']} taken back)" if facts["taken_back"] else ""
    terminal.say(
        f"{facts['name']}: {counts or 'no sample'}{taken_back}",
        f"  robot      {metadata.get('robot', 'not known')}",
        f"  distance   {_length(facts['distance'])} between sockets 0 and 1",
        *(
            f"  changed    {_told(change)}"
            for change in _listed(metadata.get("changes"))
        ),
        f"  efforts    {'recorded' if facts['efforts'] else 'none'}",
        *(f"  {line}" for line in _joint_lines(facts)),
        *(
            f"  session    {_told(session)}"
            for session in _listed(metadata.get("sessions"))
        ),
    )
    terminal.warn(*facts["remarks"])


def _listed(value: Any) -> list[Any]:
    """Return a list of the metadata, which may be written by hand, and hold anything."""
    return cast("list[Any]", value) if isinstance(value, list) else []


def _length(distance: Any) -> str:
    if isinstance(distance, int | float):
        return f"{1e3 * distance:g} mm"
    return "not known" if distance is None else str(distance)


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
    changes = _listed(facts["distance"])
    changed = (
        _change(*changes) if len(changes) == 2 else ", ".join(map(_length, changes))
    )
    return f"distance {changed}, {facts.get('time', 'at an unknown time')}"


def _joint_lines(facts: dict[str, Any]) -> list[str]:
    """One line a joint: the range covered, in degrees, or mm for a prismatic joint."""
    if not facts["samples"]:
        return []
    count = len(facts["joints"])
    units = _listed(facts["metadata"].get("units"))
    units_shown = units if len(units) == count else [""] * count
    spreads = facts["largest_spread"] or [None] * count
    rows = zip(
        facts["joints"],
        units_shown,
        facts["lowest"],
        facts["highest"],
        spreads,
        strict=True,
    )
    width = max(map(len, facts["joints"]))
    lines: list[str] = []
    for name, unit, lowest, highest, spread in rows:
        scale, sign = (1e3, " mm") if unit == "m" else (math.degrees(1), "°")
        line = f"{name:<{width}}  {scale * lowest:8.1f}{sign} to {scale * highest:7.1f}{sign}"
        lines.append(
            line + (f"  spread up to {scale * spread:.4f}{sign}" if spread else "")
        )
    return lines


HALF = 0.5
"""Share of a joint's range below which the rest are turns that its readings gained or lost."""
_PLACE = ("x", "y", "z")
_NAMES = ("q", "effort", "socket", *_PLACE)
_UNITS = {"rad": "q", "deg": "q", "m": _PLACE, "mm": _PLACE}
_SIZES = {"deg": math.pi / 180, "mm": 1e-3}
_SPEC = re.compile(rf"({'|'.join(_NAMES)})=(.+?)\s*(?:\[(\w+)\])?")
_RANGE = re.compile(r"(.*?)(\d+)\.\.(\d+)(.*)")
EXAMPLE = "'q=joint_1..6 [deg]' 'x=x_t+x_dif [mm]'"


def placement_of_table(file: Path, columns: Sequence[str]) -> Placement:
    """Return the placement that columns of a CSV file with a header hold, see above."""
    table = read_table(file)
    headed = [c for c in table.columns if c.name and not table.is_text(c.index)]
    numbers = dict(
        zip(
            [c.name for c in headed],
            np.transpose(table.numbers(headed, gaps=True)),
            strict=True,
        )
    )
    units = {column.name: column.unit for column in headed}
    found: dict[str, np.ndarray] = {}
    joints: list[str] = []
    for words in columns:
        spec = _SPEC.fullmatch(words.strip())
        unit = spec[3] if spec else None
        if spec is None or (unit is not None and spec[1] not in _UNITS.get(unit, ())):
            names = ", ".join(_NAMES)
            raise UsageError(f"--columns {words!r}: write {EXAMPLE}; there are {names}")
        parts = _expanded(spec[2])
        if not parts:
            raise UsageError(
                f"--columns {words!r}: no columns; count upwards, as in joint_1..6"
            )
        where = f"{file}: --columns {words!r}"
        values = np.stack(
            [_sum(part, numbers, units, unit, where) for part in parts], axis=1
        )
        if (gaps := np.argwhere(np.isnan(values))).size:
            row, column = gaps[0].tolist()
            raise UsageError(f"{table.where(row)}: {parts[column]} is no finite number")
        found[spec[1]] = values
        joints = parts if spec[1] == "q" else joints
    measured = set(_PLACE) <= set(found)
    if "q" not in found or not (measured or "socket" in found):
        raise UsageError(
            f"--columns: q is needed, and socket, or x, y and z; as in {EXAMPLE}"
        )
    sockets = found["socket"][:, 0] if "socket" in found else np.zeros(len(table.rows))
    placement = Placement.of_arrays(
        file.stem, found["q"], sockets, joints, efforts=found.get("effort")
    )
    if measured:
        points = np.hstack([found[axis] for axis in _PLACE]).tolist()
        samples = zip(placement.samples, points, strict=True)
        with_points = tuple(
            replace(sample, point=(x, y, z)) for sample, (x, y, z) in samples
        )
        placement = replace(placement, samples=with_points)
    return replace(placement, files=(file,))


def point_files(placement: Placement) -> dict[str, bytes]:
    """Return the content of ``points.csv`` by its name; orientations have no place in it."""
    lines = [",".join([*(placement.joint_names or ()), *_PLACE])]
    for sample in placement.samples:
        if sample.point is None:
            raise UsageError(
                f"{placement.name}: no instrument measured it; give --to samples"
            )
        lines.append(",".join(map(repr, [*sample.position, *sample.point])))
    return {"points.csv": ("\n".join(lines) + "\n").encode()}


def _expanded(words: str) -> list[str]:
    """Return columns between commas, and all of a range such as ``joint_1..6``."""
    parts: list[str] = []
    for word in words.split(","):
        span = _RANGE.fullmatch(word.strip())
        ends = range(int(span[2]), int(span[3]) + 1) if span else ()
        parts += [f"{span[1]}{i}{span[4]}" for i in ends] if span else [word.strip()]
    return parts


def _sum(
    words: str,
    numbers: Mapping[str, np.ndarray],
    units: Mapping[str, str],
    unit: str | None,
    where: str,
) -> np.ndarray:
    """Return a sum of columns, in radians or metres by the header's units, else by the one said."""
    name = "|".join(map(re.escape, sorted(numbers, key=len, reverse=True)))
    if (
        not re.fullmatch(rf"\s*-?\s*(?:{name})(?:\s*[+-]\s*(?:{name}))*\s*", words)
        or not numbers
    ):
        names = ", ".join(numbers) or "no names"
        raise UsageError(f"{where}: no column {words!r}; there are {names}")
    total = np.zeros(len(next(iter(numbers.values()))))
    for sign, part in re.findall(rf"(-?)\s*({name})", words):
        if unit and units[part] not in ("", unit):
            raise UsageError(
                f"{where}: the header says {units[part]!r} of {part}, not {unit!r}"
            )
        size = 1.0 if units[part] else _SIZES.get(unit or "", 1.0)
        total += (-size if sign else size) * numbers[part]
    return total


FORMS = {
    "samples": recorder.sample_files,
    "holes": recorder.hole_files,
    "points": point_files,
}


class _ConvertOptions(Options):
    path: Path = argument(
        "a placement, or a folder of them; with --columns a table", "PATH"
    )
    to: str = option(
        ...,
        "samples.csv; hole_0.csv and hole_1.csv; or points.csv of an instrument",
        choices=FORMS,
    )
    columns: Sequence[str] = option(
        (),
        "what the columns of another program's table are, as in 'q=joint_1..6 [deg]' "
        "'x=x_t+x_dif [mm]'; also y, z, socket, effort",
        "NAME=COLUMNS",
    )
    out: Path = option(..., "where to write", "DIR")
    force: bool = option(False, "overwrite files in DIR")
    distance: float | None = option(
        None,
        "distance of the sockets' centres in metres, where the recording does not say",
        "M",
        between=POSITIVE,
    )


def run_convert(options: _ConvertOptions, terminal: Terminal) -> int:
    """Read all placements, then write them."""
    refuse_existing(options.out, force=options.force)
    if options.columns:
        placements = {options.path: placement_of_table(options.path, options.columns)}
    else:
        folders = recorder.find_placements([options.path])
        placements = {folder: recorder.read_placement(folder) for folder in folders}
    outs = {
        f: options.out if f == options.path else options.out / f.name
        for f in placements
    }
    for folder, out in outs.items():
        if out.resolve() == folder.resolve():
            raise OutputError(f"{out}: is what is read; choose another --out")
    for (folder, placement), out in zip(placements.items(), outs.values(), strict=True):
        terminal.warn(*placement.remarks)
        with_distance = replace(
            placement, distance=placement.distance or options.distance
        )
        files = FORMS[options.to](with_distance)
        metadata = (
            {}
            if options.columns
            else recorder.read_metadata(folder / recorder.METADATA)
        )
        if metadata:
            metadata["distance"] = with_distance.distance
            files[recorder.METADATA] = json.dumps(metadata, indent=2).encode() + b"\n"
        for file in [*out.glob("hole_*.csv"), *out.glob("samples.csv")]:
            if file.name not in files:
                raise OutputError(
                    f"{file}: another recording is there; choose another --out"
                )
        terminal.say(*(f"Wrote {file}" for file in write_files(out, files).values()))
        if options.to == "holes" and placement.efforts is not None:
            terminal.warn(
                f"{folder}: this form has no place for efforts; they are left out"
            )
        if options.to == "holes" and any(b < a for a, b in pairwise(placement.sockets)):
            lost = "this form loses the order of recording, by which a base that moved is seen"
            terminal.warn(f"{folder}: {lost}")
    return 0
