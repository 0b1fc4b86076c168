"""Columns of another program's table, as users name them.

``q=joint_1..6 [deg]`` takes six columns, ``x=x_t+x_dif [mm]`` a sum of two. Columns have numbers,
too, from 1, as in ``q=1..6 [deg]``.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from .columns import Column, column_of
from .coordinates import AXES, TURNS
from .placement import Placement, reordered_sample
from .recording_error import RecordingError
from .tables import Table
from .words import ANGLES, LENGTHS, SIZES

_TURNING = set(chain.from_iterable(form for form in TURNS if len(form) == 3))
_NAMES = ("q", "effort", "socket", *AXES, *dict.fromkeys(chain.from_iterable(TURNS)))
_UNITS = dict.fromkeys(AXES, LENGTHS) | dict.fromkeys(_TURNING, ANGLES) | {"q": SIZES}
_SPEC = re.compile(r"(\w+)=(.+?)\s*(?:\[\s*([^\]]+?)\s*\])?")
_RANGE = re.compile(r"(.*?)(\d+)\.\.(?:\1)?(\d+)(.*)")
EXAMPLE = "'q=joint_1..6 [deg]' 'x=x_t+x_dif [mm]'"


@dataclass(frozen=True)
class NamedColumns:
    """Numbers of a table by what they are, in radians and metres."""

    numbers: Mapping[str, np.ndarray]
    """By one of the names above, shape (rows, columns); NaN where a cell holds none."""
    joints: tuple[str, ...]
    """Names of the columns of joint positions."""
    used: tuple[Column, ...]
    """All columns that are named."""


def named_columns(table: Table, words_of_user: Sequence[str]) -> NamedColumns:
    """Return the columns of a table that a user names, see above.

    Raises:
        RecordingError: They are named wrongly, or are not there.
    """
    source = _Source.of(table)
    numbers: dict[str, np.ndarray] = {}
    joints: list[str] = []
    used: list[Column] = []
    for words in words_of_user:
        name, parts, unit = _parsed(words)
        where = f"{table.file}: --columns {words!r}"
        sums: list[np.ndarray] = []
        for part in parts:
            values, columns = source.sum(part, unit, where)
            sums.append(values)
            used += columns
        columns_before = [numbers[name]] if name in numbers else []
        numbers[name] = np.hstack([*columns_before, np.stack(sums, axis=1)])
        joints += [column_of(0, part).name for part in parts] if name == "q" else []
    return NamedColumns(numbers, tuple(joints), tuple(used))


def with_columns(placement: Placement, words_of_user: Sequence[str]) -> Placement:
    """Return a folder's placement by the columns that a user names, in chain order, with signs.

    Raises:
        RecordingError: They are more than single columns of joint positions, or are not there.
    """
    names = placement.joint_names or ()
    count = len(placement.samples[0].position)
    numbers = [str(i + 1) for i in range(count)]
    columns = [*numbers, *names]
    parts: list[str] = []
    where = f"{placement.where}: --columns"
    for words in words_of_user:
        name, joints, unit = _parsed(words)
        if name != "q" or unit:
            raise RecordingError(
                f"{where} {words!r}: of samples in a folder name joints alone, as in 'q=1,-2,3'"
            )
        parts += joints
    plain = [part.removeprefix("-") for part in parts]
    if absent := {*plain}.difference(columns):
        lacking = ", ".join(sorted(absent))
        raise RecordingError(f"{where}: no {lacking}; there are {', '.join(columns)}")
    order = [columns.index(part) % count for part in plain]
    if len({*order}) < len(order):
        raise RecordingError(f"{where}: {', '.join(parts)}: a joint is named twice")
    signs = np.where([part in columns for part in parts], 1.0, -1.0)
    samples = [reordered_sample(sample, order) for sample in placement.samples]
    turned = [
        replace(s, effort=s.effort and tuple((signs * s.effort).tolist()))
        for s in samples
    ]
    renamed = replace(
        placement,
        samples=tuple(turned),
        joint_names=names if names and plain in (numbers, [*names]) else None,
        remarks=(*placement.remarks, f"{where} {' '.join(words_of_user)}"),
    )
    return renamed.with_positions(renamed.positions * signs)


def _parsed(words: str) -> tuple[str, list[str], str]:
    """Return what a user's words name, its columns, and their unit.

    Raises:
        RecordingError: They are no specification of columns, or count downwards.
    """
    match = _SPEC.fullmatch(words.strip())
    if not match or match[1] not in _NAMES:
        raise RecordingError(
            f"--columns {words!r}: write {EXAMPLE}; there are {', '.join(_NAMES)}"
        )
    unit = (match[3] or "").lower()
    known = _UNITS.get(match[1], {})
    if unit and unit not in known:
        raise RecordingError(
            f"--columns {words!r}: {match[1]} has no unit {unit!r}; write {EXAMPLE}; "
            f"units are {', '.join(known) or 'none'}"
        )
    parts = _expanded(match[2])
    if not parts:
        raise RecordingError(
            f"--columns {words!r}: no columns; count upwards, as in joint_1..6"
        )
    return match[1], parts, unit


def _expanded(words: str) -> list[str]:
    """Return columns between commas, and all of a range such as ``joint_1..6``."""
    parts: list[str] = []
    for name in map(str.strip, words.split(",")):
        span = _RANGE.fullmatch(name)
        if not span:
            parts.append(name)
            continue
        before, first, last, after = span.groups()
        parts += [f"{before}{i}{after}" for i in range(int(first), int(last) + 1)]
    return parts


@dataclass(frozen=True)
class _Source:
    """Columns of numbers of a table, by what users may call them."""

    table: Table
    columns: Mapping[str, list[Column]]
    """By a cell of the header, the same without its unit, or the column's number."""

    @classmethod
    def of(cls, table: Table) -> "_Source":
        """Return the columns of a table that hold numbers."""
        columns: dict[str, list[Column]] = {}
        numeric = table.numeric()
        for column in numeric:
            cell = table.header[column.index] if table.header else ""
            for name in filter(None, dict.fromkeys((column.name, cell))):
                columns.setdefault(name, []).append(column)
        for column in numeric:
            columns.setdefault(str(column.index + 1), [column])
        return cls(table, columns)

    def sum(
        self,
        words: str,
        unit: str,
        where: str,
    ) -> tuple[np.ndarray, list[Column]]:
        """Return a sum of columns, in radians or metres by their header, else by the unit said.

        Raises:
            RecordingError: A column is not there, several are called so, or its header says another
                unit; ``where`` begins the message.
        """
        longest_first = sorted(self.columns, key=len, reverse=True)
        name = "|".join(map(re.escape, longest_first))
        form = rf"\s*-?\s*(?:{name})(?:\s*[+-]\s*(?:{name}))*\s*"
        if not re.fullmatch(form, words):
            alone = column_of(0, words)
            if alone.unit and alone.name in self.columns:
                return self.sum(alone.name, alone.unit, where)
            names = ", ".join(self.columns)
            raise RecordingError(
                f"{where}: no column {words!r}; there are {names:.200}"
            )
        terms: list[np.ndarray] = []
        columns: list[Column] = []
        for sign, part in re.findall(rf"(-?)\s*({name})", words):
            column, *others = self.columns[part]
            if others:
                numbers = ", ".join(str(c.index + 1) for c in (column, *others))
                raise RecordingError(
                    f"{where}: {part!r} is the name of columns {numbers}; write the number"
                )
            said = column.unit
            same = SIZES.get(said) == SIZES.get(unit, math.nan)
            same_kind = (said in ANGLES) == (unit in ANGLES)
            if unit and said and not (same and same_kind):
                raise RecordingError(
                    f"{where}: the header says {said!r} of {column.name}, not {unit!r}"
                )
            size = 1.0 if said else SIZES.get(unit, 1.0)
            values = self.table.array([column])[:, 0]
            terms.append((-size if sign else size) * values)
            columns.append(column)
        return np.sum(terms, axis=0), columns
