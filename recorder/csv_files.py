"""CSV files of numbers, with or without a header, read strictly."""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .. import MukcaError

__all__ = ["RecordingError", "Table", "read_table"]


class RecordingError(MukcaError):
    """A recording cannot be read or written, or is not as it must be; the message says where."""


@dataclass(frozen=True)
class Table:
    """Numbers from a CSV file, with the line each row stands on."""

    file: Path
    header: tuple[str, ...] | None
    lines: tuple[int, ...]
    rows: tuple[tuple[float, ...], ...]


def read_table(file: Path) -> Table:
    """Read a CSV file of finite numbers, with or without a header line.

    Raises:
        RecordingError: The file is missing, empty, or only a header; its lines differ in length;
            or a cell is no finite number. The message names file and line.
    """
    try:
        with file.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream)
            records = [
                (reader.line_num, row) for row in reader if any(cell.strip() for cell in row)
            ]
    except OSError as error:
        raise RecordingError(f"{file}: cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise RecordingError(f"{file}: not a text file of comma-separated numbers") from None
    if not records:
        raise RecordingError(f"{file}: empty; expected one configuration a line")
    header = _header(records[0][1])
    if header:
        records = records[1:]
    if not records:
        raise RecordingError(f"{file}: only a header; expected one configuration a line below it")
    width = len(header or records[0][1])
    rows = tuple(_numbers(file, line, row, width) for line, row in records)
    return Table(file, header, tuple(line for line, _ in records), rows)


def _header(cells: Sequence[str]) -> tuple[str, ...] | None:
    """Return a line's cells as names if none of them is a number."""
    if any(_is_number(cell) or not cell.strip() for cell in cells):
        return None
    return tuple(cell.strip() for cell in cells)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(file: Path, line: int, cells: Sequence[str], width: int) -> tuple[float, ...]:
    if len(cells) != width:
        raise RecordingError(f"{file}:{line}: {len(cells)} columns where {width} are expected")
    try:
        numbers = tuple(float(cell) for cell in cells)
    except ValueError:
        column = next(i for i, cell in enumerate(cells) if not _is_number(cell))
        raise RecordingError(
            f"{file}:{line}: column {column + 1} is {cells[column]!r}, not a number"
        ) from None
    if not all(map(math.isfinite, numbers)):
        column = next(i for i, number in enumerate(numbers) if not math.isfinite(number))
        raise RecordingError(
            f"{file}:{line}: column {column + 1} is {cells[column].strip()}, not a finite number; "
            "delete the line if the capture failed"
        )
    return numbers
