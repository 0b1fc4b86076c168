"""Tables of other programs: cells by line and column, whatever separates and surrounds them.

Commas, semicolons, tabs or blanks; decimal commas; notes behind ``#``; a header, units in it or
below it; text, times and row numbers beside what is wanted. Nothing here knows what is wanted:
:mod:`.columns` finds it by names.
"""

import csv
import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import is_number
from .cells import (
    Cells,
    holds_number,
    number_of,
    records_of,
    require_columns,
    seconds_of,
    trimmed,
    uncommented,
)
from .columns import GARBLED, Column, Line, are_units, column_of, header_of
from .recording_error import EmptyRecordingError, RecordingError
from .words import SIZES

Arranged = Callable[[list[Line], str], tuple[list[Line], list[str]]]


@dataclass(frozen=True)
class Table:
    """Cells of a file, as text, with the line each row stands on."""

    file: Path
    header: Cells | None
    lines: tuple[int, ...]
    rows: tuple[Cells, ...]
    units: Cells = ()
    """The line of units below the header, where there is one."""
    comment: str = ""
    """Text of a first line that is a comment."""
    notes: Cells = ()
    """Remarks for people on what was left out, one line each."""

    @property
    def columns(self) -> list[Column]:
        """All columns; without a header their names are empty."""
        width = len(self.rows[0])
        below = self.units or ("",) * width
        names = self.header or ("",) * width
        return [column_of(i, names[i], below[i]) for i in range(width)]

    def where(self, row: int) -> str:
        """Return file and line of a row, for messages."""
        return f"{self.file}:{self.lines[row]}"

    def is_text(self, index: int) -> bool:
        """Return whether a column holds words, times or nothing, and no number."""
        return all(_is_text(row[index]) for row in self.rows)

    @property
    def labels(self) -> Cells:
        """Texts of the first column that holds some; empty without one."""
        for i in filter(self.is_text, range(len(self.rows[0]))):
            return tuple(row[i] for row in self.rows)
        return ()

    def names_of(self, columns: Sequence[Column]) -> tuple[str, ...] | None:
        """Return the names of columns; None without a header."""
        return tuple(column.name for column in columns) if self.header else None

    def joints(self, reserved: Collection[Column] = ()) -> list[Column]:
        """Return the columns that may be joints: numbers, and neither times nor row numbers."""
        return [c for c in self.numeric(reserved) if not (self.header and c.aside)]

    def beside(self, reserved: Collection[Column] = ()) -> list[Column]:
        """Return the columns that count or date the rows, unless a joint is called so."""
        columns = self.numeric(reserved) if self.header else []
        return [c for c in columns if c.aside and c.may_be_joint]

    def numeric(self, reserved: Collection[Column] = ()) -> list[Column]:
        """Return the columns that hold numbers, without some."""
        return [
            column
            for column in self.columns
            if column not in reserved and not self.is_text(column.index)
        ]

    def array(self, columns: Sequence[Column]) -> np.ndarray:
        """Return the numbers of K columns, shape (rows, K); NaN where a cell holds none."""
        return np.array(self.numbers(columns, gaps=True))

    def numbers(
        self,
        columns: Sequence[Column],
        *,
        gaps: bool = False,
    ) -> list[tuple[float, ...]]:
        """Return the numbers of some columns in radians and metres, row by row.

        A cell that is no finite number is refused; with ``gaps`` it is NaN, which may not matter.

        Raises:
            RecordingError: A cell is no finite number; the message names line and column.
        """
        scales = [(column.index, scale_of(column)) for column in columns]
        rows: list[tuple[float, ...]] = []
        for line, cells in zip(self.lines, self.rows, strict=True):
            row: list[float] = []
            for i, scale in scales:
                value = number_of(cells[i])
                if value is not None and is_number(value):
                    row.append(value * scale)
                elif gaps:
                    row.append(math.nan)
                else:
                    words = (
                        f"{cells[i]:.40}, not a finite number that can be measured; delete "
                        "the line if the capture failed"
                    )
                    if not cells[i].strip():
                        words = "empty; delete the line if nothing was measured"
                    elif value is None:
                        words = f"{cells[i][:40]!r}, not a number; write 0.1 and separate by commas"
                    raise RecordingError(
                        f"{self.file}:{line}: column {i + 1} is {words}"
                    )
            rows.append(tuple(row))
        return rows


def _is_text(cell: str) -> bool:
    """Return whether a cell is empty, a time or words, and no number that is garbled."""
    if not cell or seconds_of(cell) is not None:
        return True
    words = any(map(str.isalpha, cell)) and not GARBLED.fullmatch(cell)
    return words and not holds_number(cell)


def scale_of(column: Column) -> float:
    """Return a column's unit in radians or metres; 1 where none is named."""
    return SIZES.get(column.unit, 1.0)


def table_of(
    text: str,
    file: Path,
    names: Collection[str] = (),
    arranged: Arranged | None = None,
) -> Table:
    """Return the cells of a text; messages begin with the file.

    Args:
        text: Lines of cells. Commas, semicolons, tabs or blanks part them, as most lines do; by
            anything but commas, a number may have a decimal comma. Separators at the ends of all
            lines are left out.
        file: Its name, for messages.
        names: Names that a header would hold, such as a model's joints; a first line that holds
            them all is the header, whatever they look like.
        arranged: Makes lines of a program's own a header and rows, with remarks on it.

    Raises:
        RecordingError: Nothing but a header, or lines that differ in length; the message names file
            and line.
    """
    require_columns(text, file)
    try:
        records = records_of(uncommented(text))
    except csv.Error:
        raise RecordingError(
            f"{file}: not a text file of comma-separated numbers"
        ) from None
    if records and records[0][1][0].lower().startswith("sep="):
        records = records[1:]
    if not records:
        raise EmptyRecordingError(f"{file}: empty; expected one configuration a line")
    left_out: list[str] = []
    if arranged:
        records, left_out = arranged(records, text)
    while all(len(row) > 1 and not row[-1] for _, row in records):
        records = [(line, row[:-1]) for line, row in records]
    first, *others = records
    units: Cells = ()
    header = header_of(file, first, others, set(names))
    if header:
        records = others
        if records and are_units(records[0][1]):
            cells = records.pop(0)[1]
            units = (*cells, *[""] * (len(header) - len(cells)))
    if not records:
        raise EmptyRecordingError(
            f"{file}: only a header; expected one configuration a line below it"
        )
    width = len(header or records[0][1])
    lines = tuple(line for line, _ in records)
    rows = tuple(_fitting(file, line, row, width) for line, row in records)
    notes = [f"{file}:{remark}" for remark in left_out]
    if header and any(map(str.isdecimal, header)):
        words = f"{','.join(header):.40} are taken for names, not for a sample"
        notes.append(f"{file}:{first[0]}: {words}")
    top = text.partition("\n")[0]
    comment = top.lstrip("# ").strip() if top.startswith("#") else ""
    return Table(file, header, lines, rows, units, comment, tuple(notes))


def _fitting(
    file: Path,
    line: int,
    cells: Cells,
    width: int,
) -> Cells:
    """Return the cells of a row, which must be as many as are expected."""
    cells = trimmed(cells, width)
    if len(cells) != width:
        raise RecordingError(
            f"{file}:{line}: {len(cells)} columns where {width} are expected; separate them all "
            "by commas"
        )
    return tuple(cells)
