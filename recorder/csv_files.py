"""CSV files of numbers, with or without a header, read strictly."""

import csv
import io
import math
import os
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ..errors import MukcaError

_NAME = re.compile(r"[^\W\d][\w./:()\[\] -]*")
"""Name of a joint: a letter first."""
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d*([eE][+-]?\d+)?")
_DECIMAL_COMMAS = re.compile(r"[+-]?\d+,\d+(\s+[+-]?\d+,\d+)+")


class RecordingError(MukcaError):
    """A recording cannot be read or written, or is not as it must be; the message says where."""


class EmptyRecordingError(RecordingError):
    """A file that holds no configuration yet."""


@dataclass(frozen=True)
class Table:
    """Numbers from a CSV file, with the line each row stands on."""

    file: Path
    header: tuple[str, ...] | None
    lines: tuple[int, ...]
    rows: tuple[tuple[float, ...], ...]
    units: tuple[str, ...] | None = None
    """The line of units below the header, where there is one and it was looked for."""


def read_table(file: Path, *, units: bool = False) -> Table:
    """Read a file of finite numbers, with or without a header line.

    Cells are separated by commas, semicolons, tabs, or blanks, as the first line tells; by
    anything but commas, a number may have a decimal comma. Separators at the ends of all lines
    are left out.

    Args:
        file: The file.
        units: Whether the second line may hold the columns' units.

    Raises:
        RecordingError: The file is missing, empty, or only a header; its lines differ in length;
            or a cell is no finite number. The message names file and line.
    """
    try:
        text = _uncommented(file.read_text(encoding="utf-8-sig"))
        records = _records(text)
        while records and all(len(row) > 1 and not row[-1].strip() for _, row in records):
            records = [(line, row[:-1]) for line, row in records]
    except OSError as error:
        raise RecordingError(f"{file}: cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise RecordingError(f"{file}: not a text file of comma-separated numbers") from None
    if not records:
        raise EmptyRecordingError(f"{file}: empty; expected one configuration a line")
    header = _header(file, *records[0])
    named = None
    if header:
        records = records[1:]
        if units and records and not any(map(_is_number, records[0][1])):
            named = tuple(cell.strip() for cell in records.pop(0)[1])
    if not records:
        raise EmptyRecordingError(
            f"{file}: only a header; expected one configuration a line below it"
        )
    width = len(header or records[0][1])
    rows = tuple(_numbers(file, line, row, width) for line, row in records)
    return Table(file, header, tuple(line for line, _ in records), rows, named)


def comment_line(file: Path) -> str:
    """Return the text of a first line that is a comment; empty without one."""
    with file.open(encoding="utf-8-sig", errors="replace") as lines:
        first = next(lines, "")
    return first.lstrip("# ").strip() if first.startswith("#") else ""


def _uncommented(text: str) -> str:
    """Return a text whose comment lines are blank; ``# a,b`` before two numbers is a header."""
    lines = text.splitlines()
    comments = [i for i, line in enumerate(lines) if line.startswith("#")]
    data = next((line for line in lines if line.strip() and not line.startswith("#")), "")
    by = next((d for d in ";\t," if d in data.strip()), None)  # commas are decimal beside others
    for i in comments:
        words = lines[i].lstrip("# ")
        alike = by and words.count(by) == data.strip().count(by) and not data[:1].isalpha()
        lines[i] = words if alike and i == comments[-1] else ""
    return "\n".join(lines) + "\n" if comments else text


def _records(text: str) -> list[tuple[int, list[str]]]:
    """Return the cells of each line that has some, with the line's number."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    delimiter = next((d for d in ";\t" if d in first), None)
    if delimiter is None and (_DECIMAL_COMMAS.fullmatch(first.strip()) or "," not in first):
        lines = enumerate(text.splitlines(), start=1)
        return [(i, _with_points(line.split())) for i, line in lines if line.strip()]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter or ",")
    records = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    return records if delimiter is None else [(i, _with_points(row)) for i, row in records]


def _with_points(cells: Sequence[str]) -> list[str]:
    """Return cells with their decimal commas made points."""
    return [
        cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell.strip()) else cell for cell in cells
    ]


def _header(file: Path, line: int, cells: Sequence[str]) -> tuple[str, ...] | None:
    """Return a line's cells as names if none of them is a number."""
    if any(_is_number(cell) or not cell.strip() for cell in cells):
        return None
    names = tuple(cell.strip() for cell in cells)
    wrong = next((name for name in names if not _NAME.fullmatch(name)), None)
    if wrong is not None:
        raise RecordingError(
            f"{file}:{line}: {wrong!r} is neither a number nor the name of a joint; separate "
            "numbers by commas, as in 0.1,-1.5,2"
        )
    return names


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(file: Path, line: int, cells: Sequence[str], width: int) -> tuple[float, ...]:
    if len(cells) != width:
        raise RecordingError(
            f"{file}:{line}: {len(cells)} columns where {width} are expected; separate them all "
            "by commas"
        )
    try:
        numbers = tuple(float(cell) for cell in cells)
    except ValueError:
        column = next(i for i, cell in enumerate(cells) if not _is_number(cell))
        raise RecordingError(
            f"{file}:{line}: column {column + 1} is {cells[column]!r}, not a number; write 0.1 and "
            "separate by commas"
        ) from None
    if not all(map(math.isfinite, numbers)):
        column = next(i for i, number in enumerate(numbers) if not math.isfinite(number))
        raise RecordingError(
            f"{file}:{line}: column {column + 1} is {cells[column].strip()}, not a finite number; "
            "delete the line if the capture failed"
        )
    return numbers


APPEND: int = os.O_APPEND | getattr(os, "O_BINARY", 0)
"""To open a file to which bytes are appended as they are; Windows would change ends of lines."""
_BEYOND = 1 << 30


def append_bytes(descriptor: int, data: bytes, *, sync: bool = True) -> None:
    """Append to an open file, and wait until it is on the disk, or do not (``sync``).

    Raises:
        OSError: Not all could be written, as on a full disk; what was written is cut off again.
    """
    size = os.fstat(descriptor).st_size
    try:
        while data:
            data = data[os.write(descriptor, data) :]
        if sync:
            os.fsync(descriptor)
    except OSError:
        with suppress(OSError):
            os.ftruncate(descriptor, size)
            os.fsync(descriptor)
        raise


def replace_file(file: Path, content: bytes) -> None:
    """Write a file in one step: a crash leaves the old one, or the new one.

    Raises:
        OSError: It cannot be written; the old one is there, and nothing else.
    """
    temporary = file.with_name(f".{file.name}.tmp")
    try:
        with temporary.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.replace(file)
    except OSError:
        with suppress(OSError):
            temporary.unlink()
        raise
    sync_folder(file.parent)


def sync_folder(folder: Path) -> None:
    """Return once the names in a folder are on the disk."""
    if sys.platform == "win32":
        return  # folders cannot be opened there; NTFS keeps a journal of names
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def lock_file(descriptor: int) -> None:
    """Lock an open file until it is closed.

    Raises:
        BlockingIOError: Another program holds it.
    """
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, _BEYOND, os.SEEK_SET)  # what is locked there, nobody else can read
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except PermissionError as error:
            raise BlockingIOError(*error.args) from None
    else:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
