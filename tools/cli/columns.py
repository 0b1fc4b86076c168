"""Tables of others: a placement from columns that the user names.

``q=joint_1..6 [deg]`` takes six columns, ``x=x_t+x_dif [mm]`` a sum of two.
"""

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...recorder import Placement, Sample, read_table
from ...solver.calibration import UsageError

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
