"""Columns of another program's table, as users name them.

``q=joint_1..6 [deg]`` takes six columns, ``x=x_t+x_dif [mm]`` a sum of two.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ....recorder import Placement, Sample, Table, read_table
from ....solver.calibration import UsageError

PLACE = ("x", "y", "z")
_NAMES = ("q", "effort", "socket", *PLACE)
_UNITS = {"rad": "q", "deg": "q", "m": PLACE, "mm": PLACE}
_SIZES = {"deg": math.pi / 180, "mm": 1e-3}
_SPEC = re.compile(rf"({'|'.join(_NAMES)})=(.+?)\s*(?:\[(\w+)\])?")
_RANGE = re.compile(r"(.*?)(\d+)\.\.(\d+)(.*)")
EXAMPLE = "'q=joint_1..6 [deg]' 'x=x_t+x_dif [mm]'"


@dataclass(frozen=True)
class _NamedColumn:
    """Columns that a user names, such as ``q=joint_1..6 [deg]``."""

    name: str
    """One of :data:`_NAMES`."""
    parts: list[str]
    """A column of the table each, or a sum of some."""
    unit: str | None
    """None where the table's header says it."""


def placement_of_table(file: Path, columns: Sequence[str]) -> Placement:
    """Return the placement that columns of a CSV file with a header hold, see above.

    Raises:
        UsageError: Columns are named wrongly, or are not there, or hold no finite number.
    """
    table = read_table(file)
    source = _Source.of(table)
    values: dict[str, np.ndarray] = {}
    joints: list[str] = []
    for words in columns:
        column = _column_of(words)
        where = f"{file}: --columns {words!r}"
        sums = [source.sum(part, column.unit, where) for part in column.parts]
        numbers = np.stack(sums, axis=1)
        gaps = np.argwhere(np.isnan(numbers))
        if gaps.size:
            row, k = map(int, gaps[0])
            part = column.parts[k]
            raise UsageError(f"{table.where(row)}: {part} is no finite number")
        values[column.name] = numbers
        if column.name == "q":
            joints = column.parts
    measured = set(PLACE) <= set(values)
    if "q" not in values or not (measured or "socket" in values):
        raise UsageError(
            f"--columns: q is needed, and socket, or x, y and z; as in {EXAMPLE}"
        )
    sockets = np.zeros(len(table.rows))
    if "socket" in values:
        sockets = values["socket"][:, 0]
    efforts = values.get("effort")
    placement = Placement.of_arrays(
        file.stem, values["q"], sockets, joints, efforts=efforts
    )
    if measured:
        points = np.hstack([values[axis] for axis in PLACE])
        placement = _with_points(placement, points)
    return replace(placement, files=(file,))


def _with_points(placement: Placement, points: np.ndarray) -> Placement:
    """Return a placement with the ball's measured positions, shape (samples, 3) [m]."""
    samples: list[Sample] = []
    for sample, (x, y, z) in zip(placement.samples, points.tolist(), strict=True):
        samples.append(replace(sample, point=(x, y, z)))
    return replace(placement, samples=tuple(samples))


def _column_of(words: str) -> _NamedColumn:
    """Return what a user's words name.

    Raises:
        UsageError: They are no specification of columns, or count downwards.
    """
    match = _SPEC.fullmatch(words.strip())
    unit = match[3] if match else None
    fits = unit is None or (match and match[1] in _UNITS.get(unit, ()))
    if match is None or not fits:
        names = ", ".join(_NAMES)
        raise UsageError(f"--columns {words!r}: write {EXAMPLE}; there are {names}")
    parts = _expanded(match[2])
    if not parts:
        raise UsageError(
            f"--columns {words!r}: no columns; count upwards, as in joint_1..6"
        )
    return _NamedColumn(match[1], parts, unit)


def _expanded(words: str) -> list[str]:
    """Return columns between commas, and all of a range such as ``joint_1..6``."""
    parts: list[str] = []
    for word in words.split(","):
        name = word.strip()
        span = _RANGE.fullmatch(name)
        if span is None:
            parts.append(name)
            continue
        first = int(span[2])
        last = int(span[3])
        parts += [f"{span[1]}{i}{span[4]}" for i in range(first, last + 1)]
    return parts


@dataclass(frozen=True)
class _Source:
    """Columns of numbers of a table, by their names."""

    numbers: Mapping[str, np.ndarray]
    """Numbers of each column, in radians and metres by the header's units."""
    units: Mapping[str, str]
    """Units that the header says."""

    @classmethod
    def of(cls, table: Table) -> "_Source":
        """Return the columns of a table that have a name and hold numbers."""
        columns = [c for c in table.columns if c.name and not table.is_text(c.index)]
        names = [column.name for column in columns]
        rows = np.transpose(table.numbers(columns, gaps=True))
        units = {column.name: column.unit for column in columns}
        return cls(dict(zip(names, rows, strict=True)), units)

    def sum(self, words: str, unit: str | None, where: str) -> np.ndarray:
        """Return a sum of columns, in radians or metres by their header, else by the unit said.

        Raises:
            UsageError: A column is not there, or its header says another unit; ``where`` begins
                the message.
        """
        longest_first = sorted(self.numbers, key=len, reverse=True)
        name = "|".join(map(re.escape, longest_first))
        form = rf"\s*-?\s*(?:{name})(?:\s*[+-]\s*(?:{name}))*\s*"
        if not self.numbers or not re.fullmatch(form, words):
            names = ", ".join(self.numbers) or "no names"
            raise UsageError(f"{where}: no column {words!r}; there are {names}")
        terms: list[np.ndarray] = []
        for sign, part in re.findall(rf"(-?)\s*({name})", words):
            unit_of_header = self.units[part]
            if unit and unit_of_header not in ("", unit):
                raise UsageError(
                    f"{where}: the header says {unit_of_header!r} of {part}, not {unit!r}"
                )
            size = 1.0 if unit_of_header else _SIZES.get(unit or "", 1.0)
            terms.append((-size if sign else size) * self.numbers[part])
        return np.sum(terms, axis=0)
