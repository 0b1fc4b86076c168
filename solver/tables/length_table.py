"""Tables of measured lengths that people write: names, then lengths whose header says their unit.

``#`` begins a note, and columns stand in any order, as in::

    from,to,distance [mm],deviation [mm]
    left:0,right:0,350.02,0.1
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from ...errors import MukcaError
from ...recorder import LENGTHS, Column, RecordingError, read_text, table_of


def text_without_notes(file: Path) -> str:
    """Return the text of a file without what ``#`` begins."""
    return re.sub("#.*", "", read_text(file))


def read_lengths(
    file: Path, names: Sequence[str], lengths: Sequence[str], error: type[MukcaError]
) -> Iterator[tuple[int, list[str], list[float]]]:
    """Yield the line of each row, its names and its lengths [m].

    Args:
        file: A file with a header.
        names: Columns with names of things.
        lengths: Columns with lengths, whose unit the header names.
        error: What is raised for another table, or a cell that is no length.
    """
    header = ",".join([*names, *(f"{name} [mm]" for name in lengths)])
    try:
        text = text_without_notes(file)
        if not text.strip():
            raise RecordingError(
                f"{file}: empty; expected a CSV file with the header {header}"
            )
        table = table_of(text, file)
    except RecordingError as problem:
        raise error(str(problem)) from None
    columns: list[Column] = []
    for name in (*names, *lengths):
        called = [column for column in table.columns if column.name.lower() == name]
        if len(called) != 1:
            raise error(
                f"{file}:1: column {name!r}: expected one; a header is {header}"
            )
        columns += called
    of_lengths = columns[len(names) :]
    for column in of_lengths:
        if column.unit not in LENGTHS:
            raise error(f"{file}:1: {_words_of_unit(column)}")
    for line, cells in zip(table.lines, table.rows, strict=True):
        values: list[float] = []
        for column in of_lengths:
            cell = cells[column.index]
            try:
                values.append(LENGTHS[column.unit] * float(cell))
            except ValueError:
                raise error(f"{file}:{line}: {cell!r:.40} is no length") from None
        texts = [cells[column.index].strip() for column in columns[: len(names)]]
        yield line, texts, values


def _words_of_unit(column: Column) -> str:
    """Return what is wrong with the unit of a column of lengths, and what would be right."""
    unit = f"unit {column.unit!r}" if column.unit else "no unit"
    name = column.name
    return f"column {name} has {unit}; write {name} [mm] or [m]"
