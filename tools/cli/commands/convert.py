"""``mukca convert``: recordings in the other form, and placements from columns that the user names.

``q=joint_1..6 [deg]`` takes six columns, ``x=x_t+x_dif [mm]`` a sum of two.
"""

import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from .... import recorder
from ....recorder import Placement, Sample, read_table
from ....solver.calibration import UsageError
from ....solver.results import OutputError, refuse_existing, write_files
from .. import POSITIVE, Terminal, argument, option

_PLACE = ("x", "y", "z")
_NAMES = ("q", "effort", "socket", *_PLACE)
_UNITS = {"rad": "q", "deg": "q", "m": _PLACE, "mm": _PLACE}
_SIZES = {"deg": math.pi / 180, "mm": 1e-3}
_SPEC = re.compile(rf"({'|'.join(_NAMES)})=(.+?)\s*(?:\[(\w+)\])?")
_RANGE = re.compile(r"(.*?)(\d+)\.\.(\d+)(.*)")
EXAMPLE = "'q=joint_1..6 [deg]' 'x=x_t+x_dif [mm]'"


def placement_of_table(file: Path, columns: Sequence[str]) -> Placement:
    """Return the placement that columns of a CSV file with a header hold, see above.

    Raises:
        UsageError: A word that is none, a column that is missing, or too little for a placement.
        RecordingError: The file is no table of numbers.
    """
    table = read_table(file)
    numbers, names = np.array(table.rows), list(table.header or ())
    found: dict[str, np.ndarray] = {}
    joints: list[str] = []
    for words in columns:
        spec = _SPEC.fullmatch(words.strip())
        unit = spec[3] if spec else None
        if spec is None or (unit is not None and spec[1] not in _UNITS.get(unit, ())):
            known = ", ".join(_NAMES)
            raise UsageError(f"--columns {words!r}: write {EXAMPLE}; there are {known}")
        parts = _expanded(spec[2])
        if not parts:
            raise UsageError(f"--columns {words!r}: no columns; count upwards, as in joint_1..6")
        values = [_sum(part, names, numbers, f"{file}: --columns {words!r}") for part in parts]
        found[spec[1]] = np.stack(values, axis=1) * _SIZES.get(unit or "", 1.0)
        joints = parts if spec[1] == "q" else joints
    measured = set(_PLACE) <= set(found)
    if "q" not in found or not (measured or "socket" in found):
        raise UsageError(f"--columns: q is needed, and socket, or x, y and z; as in {EXAMPLE}")
    columns_of = [
        found.get(name, np.zeros((len(numbers), 1)))[:, 0] for name in ("socket", *_PLACE)
    ]
    samples = tuple(
        Sample(
            tuple(found["q"][i].tolist()),
            int(socket),
            tuple(found["effort"][i].tolist()) if "effort" in found else None,
            f"{file}:{line}",
            point=(x, y, z) if measured else None,
        )
        for i, (line, socket, x, y, z) in enumerate(
            zip(table.lines, *(column.tolist() for column in columns_of), strict=True)
        )
    )
    return Placement(file.stem, samples, tuple(joints), files=(file,))


def point_files(placement: Placement) -> dict[str, bytes]:
    """Return the content of ``points.csv`` by its name; orientations have no place in it."""
    lines = [",".join([*(placement.joint_names or ()), *_PLACE])]
    for sample in placement.samples:
        if sample.point is None:
            raise UsageError(f"{placement.name}: no instrument measured it; give --to samples")
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


def _sum(words: str, names: Sequence[str], numbers: np.ndarray, where: str) -> np.ndarray:
    """Return a column, or a sum or difference of several."""
    name = "|".join(map(re.escape, sorted(names, key=len, reverse=True)))
    if not re.fullmatch(rf"\s*-?\s*(?:{name})(?:\s*[+-]\s*(?:{name}))*\s*", words) or not names:
        raise UsageError(
            f"{where}: no column {words!r}; there are {', '.join(names) or 'no names'}"
        )
    parts = re.findall(rf"(-?)\s*({name})", words)
    total = [(-1.0 if sign else 1.0) * numbers[:, names.index(part)] for sign, part in parts]
    return np.sum(total, axis=0)


FORMS = {"samples": recorder.sample_files, "holes": recorder.hole_files, "points": point_files}


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of ``mukca convert``."""

    path: Path = argument("a placement, or a folder of them; with --columns a table", "PATH")
    to: str = option(
        "samples.csv; hole_0.csv and hole_1.csv; or points.csv of an instrument",
        default=...,
        choices=FORMS,
    )
    columns: Sequence[str] = option(
        "what the columns of another program's table are, as in 'q=joint_1..6 [deg]' "
        "'x=x_t+x_dif [mm]'; also y, z, socket, effort",
        "NAME=COLUMNS",
        (),
    )
    out: Path = option("where to write", "DIR", ...)
    force: bool = option("overwrite files in DIR", default=False)
    distance: float | None = option(
        "distance of the sockets' centres in metres, where the recording does not say",
        "M",
        between=POSITIVE,
    )


def run_convert(options: Options, terminal: Terminal) -> int:
    """Read all placements, then write them."""
    refuse_existing(options.out, force=options.force)
    folders = [options.path] if options.columns else recorder.find_placements([options.path])
    placements = [
        placement_of_table(folder, options.columns)
        if options.columns
        else recorder.read_placement(folder)
        for folder in folders
    ]
    outs = [options.out if f == options.path else options.out / f.name for f in folders]
    for folder, out in zip(folders, outs, strict=True):
        if out.resolve() == folder.resolve():
            raise OutputError(f"{out}: is what is read; choose another --out")
    for folder, placement, out in zip(folders, placements, outs, strict=True):
        terminal.warn(*placement.remarks)
        known = replace(placement, distance=placement.distance or options.distance)
        files = FORMS[options.to](known)
        metadata = {} if options.columns else recorder.read_metadata(folder / recorder.METADATA)
        if metadata:
            metadata["distance"] = known.distance
            files[recorder.METADATA] = json.dumps(metadata, indent=2).encode() + b"\n"
        for file in [*out.glob("hole_*.csv"), *out.glob("samples.csv")]:
            if file.name not in files:
                raise OutputError(f"{file}: another recording is there; choose another --out")
        terminal.say(*(f"Wrote {file}" for file in write_files(out, files).values()))
        if options.to == "holes" and placement.efforts is not None:
            terminal.warn(f"{folder}: this form has no place for efforts; they are left out")
        if options.to == "holes" and any(b < a for a, b in pairwise(placement.sockets)):
            lost = "this form loses the order of recording, by which a base that moved is seen"
            terminal.warn(f"{folder}: {lost}")
    return 0
