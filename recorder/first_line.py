"""The first line of a table: names of columns, a title, or a sample; and units below it."""

import re
from collections.abc import Sequence
from pathlib import Path

from .cells import number_of, trimmed
from .columns import OTHER_UNITS, SIZES
from .recording_error import RecordingError

GARBLED = re.compile(r"[\[('\"]*[+-]?\d+([.,]\d+)?\s*([|'\"\])].*|deg|rad|°|mm|m)")
"""A number with something attached, which is no name."""
_DECIMAL = re.compile("[.eE]")
_LOOKED_AT = 20
"""Rows below a first line by which it is judged."""
_NUMBERED = 3
"""Fewest whole numbers in a row, such as 0,1,2, that are names and no sample."""
Line = tuple[int, list[str]]
"""Number and cells."""


def header_of(
    text: str,
    file: Path,
    first: Line,
    others: Sequence[Line],
    names: set[str],
) -> tuple[str, ...] | None:
    """Return the names of columns in the first line of a text; None where it is a sample.

    Raises:
        RecordingError: It is a title, or garbled.
    """
    _refuse_title(text, file, first, others)
    line, cells = first
    header = tuple(cell.strip() for cell in cells)
    if names and names <= set(header):
        return header
    if header and all(map(GARBLED.fullmatch, header)):
        raise RecordingError(
            f"{file}:{line}: {header[0]!r} is neither a number nor the name of a joint; separate "
            "numbers by commas, as in 0.1,-1.5,2"
        )
    below = [row[: len(header)] for _, row in others[:_LOOKED_AT]]
    numbers = [i for i, cell in enumerate(header) if number_of(cell) is not None]
    if not numbers:
        return header if not below or any(map(_has_number, below)) else None
    # Names that are numbers are whole ones, each once and one after the other, in any order.
    if len(numbers) < _NUMBERED or not all(header[i].isdecimal() for i in numbers):
        return None
    counts = sorted(int(header[i]) for i in numbers)
    if not below or counts != list(range(counts[0], counts[0] + len(counts))):
        return None
    for row in below:
        under = [row[i] for i in numbers if i < len(row)]
        if not any(
            number_of(cell) is not None and _DECIMAL.search(cell) for cell in under
        ):
            return None
    return header


def _refuse_title(
    text: str,
    file: Path,
    first: Line,
    others: Sequence[Line],
) -> None:
    """Refuse a first line of words that is a title, or does not name all columns below it.

    Raises:
        RecordingError: Each line below has more cells, or is not parted by the same separator.
    """
    line, words = first
    widths = {len(trimmed(cells, len(words))) for _, cells in others}
    has_width = len(widths) == 1 and len(words) not in widths
    no_header = has_width and (min(widths) == 1 or len(words) < min(widths))
    # Spreadsheets pad a title with separators.
    size = len(trimmed(words, 1))
    nameless = [cells[size : len(words)] for _, cells in others[:_LOOKED_AT]]
    is_text = bool(words[0].strip()) and number_of(words[0]) is None
    is_padded = is_text and max(map(count_numbers, nameless), default=0) > size
    if is_padded or (no_header and not _has_number(words)):
        title = text.splitlines()[line - 1].strip(" ,;\t")
        raise RecordingError(
            f"{file}:{line}: {title!r:.60} is no header of the lines below it, which have another "
            "number of columns; name each column, or begin the line with #"
        )


def count_numbers(cells: Sequence[str]) -> int:
    """Return how many cells are numbers."""
    return sum(number_of(cell) is not None for cell in cells)


def _has_number(cells: Sequence[str]) -> bool:
    return count_numbers(cells) > 0


def are_units(cells: Sequence[str]) -> bool:
    """Return whether a line holds units: no number, and at least one that is known."""
    units = {cell.strip(" []()").lower() for cell in cells}
    return not _has_number(cells) and not units.isdisjoint({*SIZES, *OTHER_UNITS})
