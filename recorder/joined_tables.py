"""Two tables of the same rows made one: by a column that both have, or by their order."""

import shlex
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import partial, reduce
from pathlib import Path

from .cells import number_of
from .foreign_tables import read_table
from .placement_names import placement_name
from .recording_error import RecordingError
from .tables import Table

TABLES = (".csv", ".tsv", ".txt", ".dat", ".xlsx")
"""Endings of files that are read as tables."""


def tables_at(path: Path) -> list[Path]:
    """Return the tables that a path names: one, or several as in ``joints.csv+points.csv``."""
    names = [str(path)] if path.exists() else str(path).split("+")
    files = list(map(Path, names))
    named = [f.is_file() and f.suffix.lower() in TABLES for f in files]
    return files if all(named) else []


def read_joined(path: Path, on: str = "") -> Table:
    """Return the table that a path names, or several as one by :func:`joined`."""
    return reduce(partial(joined, on=on), map(read_table, tables_at(path)))


def joined(
    first: Table,
    second: Table,
    on: str = "",
) -> Table:
    """Return the rows of two tables side by side, in the order of the first.

    Args:
        first: A table; messages name its lines.
        second: Another one.
        on: Name of a column of both, or its number, by whose cells rows belong together; empty for
            tables of which each row belongs to the same one of the other.

    Raises:
        RecordingError: Their rows are not as many, no such column, or one of its cells is twice
            there.
    """
    blanks = [("",) * len(table.rows[0]) for table in (first, second)]
    header = None
    if first.header or second.header:
        header = (*(first.header or blanks[0]), *(second.header or blanks[1]))
    units = ()
    if first.units or second.units:
        units = (*(first.units or blanks[0]), *(second.units or blanks[1]))
    pairs = [(i, i) for i in range(len(first.rows))]
    notes = (*first.notes, *second.notes)
    if on:
        pairs, remarks = _by_cells(first, second, on)
        notes = (*notes, *remarks)
        # The cells of the second table's column say nothing more.
        width = len(first.rows[0]) + _column(second, on)
        header = header and (*header[:width], "", *header[width + 1 :])
    elif len(first.rows) != len(second.rows):
        counts = f"{first.file} has {len(first.rows)} rows, {second.file} has {len(second.rows)}"
        raise RecordingError(f"{counts}; {_advice(first, second)}")
    else:
        words = f"rows belong together in their order; if not, {_advice(first, second)}"
        notes = (*notes, f"{first.file}, {second.file}: {words}")
    rows = tuple((*first.rows[i], *second.rows[j]) for i, j in pairs)
    lines = tuple(first.lines[i] for i, _ in pairs)
    return replace(
        first, header=header, units=units, lines=lines, rows=rows, notes=notes
    )


def _advice(first: Table, second: Table) -> str:
    """Return how to join two tables, by the name of a column of both if there is one."""
    names_of_second = {column.name.lower() for column in second.columns} - {""}
    names = [c.name for c in first.columns if c.name.lower() in names_of_second]
    example = shlex.quote(names[0]) if names else "NAME"
    return f"join them by a column of both, --on {example}"


def _column(table: Table, on: str) -> int:
    """Return the index of the column by which tables are joined."""
    names = [column.name for column in table.columns]
    cells = table.header or ()
    numbers = [str(i + 1) for i in range(len(names))]
    small = list(map(str.lower, names))  # the other file may write Point for point
    pairs = ((cells, on), (names, on), (numbers, on), (small, on.lower()))
    for called, word in pairs:
        if called.count(word) == 1:
            return called.index(word)
    there = ", ".join(filter(None, cells)) or f"1 to {len(names)}"
    raise RecordingError(f"{table.file}: no column --on {on!r}; there are {there:.150}")


def _by_cells(
    first: Table,
    second: Table,
    on: str,
) -> tuple[list[tuple[int, int]], list[str]]:
    """Return pairs of rows whose cells in a column are the same, and remarks on the others."""
    keys = _keys(first, _column(first, on))
    keys_of_second = _keys(second, _column(second, on))
    rows_of_second = {key: j for j, key in enumerate(keys_of_second)}
    pairs = [(i, rows_of_second[k]) for i, k in enumerate(keys) if k in rows_of_second]
    if not pairs:
        raise RecordingError(
            f"{first.file}, {second.file}: no row has the same {on!r} in both"
        )
    remarks: list[str] = []
    for table, own, of_other in (
        (first, keys, keys_of_second),
        (second, keys_of_second, keys),
    ):
        alone = [i for i, key in enumerate(own) if key not in set(of_other)]
        lines = ", ".join(str(table.lines[i]) for i in alone)
        if alone:
            remarks.append(
                f"{table.file}: {len(alone)} rows have no {on!r} of the other file and are left "
                f"out (lines {lines:.80})"
            )
    return pairs, remarks


def _keys(table: Table, column: int) -> Sequence[str | float]:
    """Return the cells of a column, numbers as such; a RecordingError where one is twice there."""
    cells = [row[column] for row in table.rows]
    keys = [cell if (n := number_of(cell)) is None else n for cell in cells]
    key, count = Counter(keys).most_common(1)[0]
    if count > 1:
        i = len(keys) - 1 - keys[::-1].index(key)
        raise RecordingError(
            f"{table.where(i)}: {cells[i]!r} is twice in the column by which rows are joined"
        )
    return keys


def joined_name(path: Path, table: Table) -> str:
    """Return the name of the placement of a table, by the files that are joined in it."""
    stems = "+".join(file.stem for file in tables_at(path))
    return placement_name(table.file.with_name(stems))
