"""Text of tables: bytes to text, text to cells, and cells to numbers and times."""

import csv
import io
import re
from collections.abc import Sequence
from datetime import datetime
from itertools import chain
from pathlib import Path

from ..errors import read_bytes
from .files import refused
from .recording_error import RecordingError

Cells = Sequence[str]
"""Cells of a line."""
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d*([eE][+-]?\d+)?")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_DECIMAL_COMMAS = re.compile(r"[+-]?\d+,\d+(\s+[+-]?\d+,\d+)+")
ZIP = b"PK\x03\x04"
"""First bytes of XLSX, ODS or an archive."""
_XLS = b"\xd0\xcf\x11\xe0"
NO_TEXT = "a spreadsheet or archive, not text; save it as CSV"
_PLAIN = str.maketrans("\N{MINUS SIGN}₀₁₂₃₄₅₆₇₈₉", "-0123456789")
MOST_COLUMNS = 10_000
"""Number of columns that no table exceeds."""
LONGEST_LINE = 1_000_000
"""Size that no line of a table exceeds [bytes]."""
_LIST = re.compile(r"[ \t]*p?[\[(]+[ \t]*([+-]?[\d.][^\[\]()]*)[\])]+[,;]?[ \t]*")
_LOOKED_AT = 8
"""Lines by which the separator is told."""
_NOTE = re.compile(r"(?m)(?:^|[ \t;,]+)//.*$")
"""A note behind two strokes; those of an address follow a colon."""
_COMMENT = re.compile(r"(?m)^(//|%)")
_TIME = re.compile(
    r"(?:(\d{4}-\d\d-\d\d)[T ])?(\d\d:\d\d:\d\d)(?:[.,](\d+))?\s*(Z|[+-]\d\d:?\d\d)?",
    re.IGNORECASE,
)


def read_text(file: Path) -> str:
    """Return the text of a file: UTF-8, UTF-16 with its mark, or one byte a letter."""
    content = table_bytes(file)
    if content.startswith((ZIP, _XLS)):
        raise RecordingError(f"{file}: {NO_TEXT}")
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    if re.search(r"[\0-\b\x0e-\x1f\x7f-\x9f\ufeff\ufffe\uffff]", text):
        raise RecordingError(f"{file}: not a text file of comma-separated numbers")
    return with_signs(text)


def with_signs(text: str) -> str:
    """Return a text whose minus signs are hyphens, and whose indices are digits."""
    return text.translate(_PLAIN)


def table_bytes(file: Path) -> bytes:
    """Return the bytes of a table; refuse one with a line that is too long to be a row.

    Raises:
        RecordingError: The file cannot be read, or a line is too long.
    """
    with refused(f"{file}: cannot be read"):
        content = read_bytes(file)
    lines = content.split(b"\n" if b"\n" in content else b"\r")
    sizes = list(map(len, lines))
    longest = max(sizes)
    if longest > LONGEST_LINE:
        limit = f"{LONGEST_LINE / 1e6:g} MB"
        raise RecordingError(
            f"{file}:{sizes.index(longest) + 1}: a line of {longest / 1e6:,.1f} MB; "
            f"at most {limit} are read"
        )
    return content


def require_columns(text: str, file: Path) -> None:
    """Refuse a table that has too many columns, before its cells are taken apart."""
    for i, line in enumerate(text.splitlines(), start=1):
        if len(line) <= MOST_COLUMNS:
            continue
        line = re.sub('"[^"]*"', '""', line)
        separators = max(map(line.count, ",;\t"))
        count = separators + 1 if separators else len(line.split())
        if count > MOST_COLUMNS:
            words = f"{count:,} columns; at most {MOST_COLUMNS:,} are read"
            raise RecordingError(f"{file}:{i}: {words}")


def uncommented(text: str) -> str:
    """Return a text without comments; ``# a,b`` before two numbers is a header.

    Comments are lines that begin with ``#``, ``%`` or ``//``, and what follows ``//``.
    """
    text = _NOTE.sub("", _COMMENT.sub("#", text))
    lines = text.splitlines()
    comments = [i for i, line in enumerate(lines) if line.startswith("#")]
    rows = [line for line in lines if line.strip() and not line.startswith("#")]
    if rows and all(map(_LIST.fullmatch, rows)):  # as [0.1, 0.2]
        lines = [_LIST.sub(r"\1", line) for line in lines]
        rows[0] = _LIST.sub(r"\1", rows[0])
    elif not comments:
        return text
    words = lines[comments[-1]].lstrip("# ") if comments else ""
    for i in comments:
        lines[i] = ""
    data = rows[0].strip() if rows else ""
    separator = next((d for d in ";\t," if d in data), None)
    if separator is None:
        is_header = len(words.split()) == len(data.split()) > 1
    else:  # commas are decimal beside others
        as_many = words.count(separator) == data.count(separator)
        cells = data.split(separator)
        numbers = [number_of(cell.replace(",", ".")) for cell in cells]
        is_header = as_many and numbers.count(None) < len(numbers)
    if comments and is_header:
        lines[comments[-1]] = words
    return "\n".join(lines) + "\n"


def records_of(text: str) -> list[tuple[int, list[str]]]:
    """Return the cells of each line that has some, without blanks around, with its number."""
    delimiter = _delimiter(text)
    if delimiter is None:
        lines = enumerate(text.splitlines(), start=1)
        return [(i, _with_points(line.split())) for i, line in lines if line.strip()]
    reader = csv.reader(
        io.StringIO(text, newline=""),
        delimiter=delimiter,
        skipinitialspace=delimiter != "\t",
    )
    lines = [(reader.line_num, [*map(str.strip, row)]) for row in reader]
    records = [(i, row) for i, row in lines if any(row)]
    if delimiter == ",":
        # Fractions with decimal commas are quoted, all of them, and no thousands as in 1,000.
        cells = [*chain.from_iterable(row for _, row in records)]
        with_point = any("." in cell and holds_number(cell) for cell in cells)
        with_comma = filter(_DECIMAL_COMMA.fullmatch, cells)
        if '"' not in text or with_point or all(map(_THOUSANDS.fullmatch, with_comma)):
            return records
    return [(i, _with_points(row)) for i, row in records]


def _delimiter(text: str) -> str | None:
    """Return what parts the cells of at least half of some lines; None for blanks."""
    unquoted = re.sub(r'"[^"\n]*"', '""', text)
    lines = [line.strip() for line in unquoted.splitlines() if line.strip()]
    # Titles stand above the numbers, so the middle tells better.
    lines = lines[(len(lines) - 1) // 2 :][:_LOOKED_AT]
    for mark in ";\t,":
        if 2 * sum(mark in line for line in lines) >= max(len(lines), 1):
            blanks = mark == "," and any(map(_DECIMAL_COMMAS.fullmatch, lines))
            return None if blanks else mark
    return None


def _with_points(cells: Cells) -> list[str]:
    """Return cells with their decimal commas made points."""
    return [
        cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell
        for cell in cells
    ]


_BY_NUMPY = re.compile(r"\s*np\.float\d\d\((.*)\)\s*")
"""A number as NumPy 2 prints it."""


def number_of(cell: str) -> float | None:
    """Return the number in a cell, also one that is not finite; None for text."""
    try:
        return None if "_" in cell else float(cell)
    except ValueError:
        by_numpy = _BY_NUMPY.fullmatch(cell)
        return number_of(by_numpy[1]) if by_numpy else None


def holds_number(cell: str) -> bool:
    """Tell whether a cell is a number, finite or not."""
    return number_of(cell) is not None


def seconds_of(cell: str) -> float | None:
    """Return the seconds of a time such as 2026-05-12T10:00:00.123Z, or 10:00:00; else None."""
    match = _TIME.fullmatch(cell)
    if not match:
        return None
    day, clock, fraction, zone = match.groups()
    offset = "+00:00" if zone in (None, "Z", "z") else f"{zone[:3]}:{zone[-2:]}"
    try:
        moment = datetime.fromisoformat(f"{day or '1970-01-01'}T{clock}{offset}")
    except ValueError:
        return None
    return moment.timestamp() + float(f"0.{fraction or 0}")


def trimmed(cells: Cells, width: int) -> Cells:
    """Return the cells of a row without empty ones beyond a width."""
    while len(cells) > width and not cells[-1]:
        cells = cells[:-1]
    return cells
