"""Columns of tables: their names in the first line, their units, and those that count the rows."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from .cells import Cells, holds_number
from .recording_error import RecordingError
from .words import OTHER_UNITS, SIZES, WORDS, Words, all_match, is_word, words_of

_UNIT = re.compile(
    r"(.*?)[\s_]*(?:\[\s*([^\d\W][^\]]*|°)\]|\(\s*([^\d\W][^)]*|°)\)|"
    r"[\s_/]+(?:in[\s_]+)?(deg(?:rees?)?|grad|rad(?:ians?)?|[°º]|mm|cm))",
    re.IGNORECASE,
)
_BEHIND = {*SIZES, *OTHER_UNITS} - {"a", "s"}
"""Units in parentheses; single letters may be anything."""
_METRES = re.compile(r"((?:.*[\W_])?(?:[xyz]|distance|deviation))_m", re.IGNORECASE)
_DEGREES = re.compile(r"(?:^|[\W_])(deg(?:rees?)?)(?:[\W_]|$)", re.IGNORECASE)


@dataclass(frozen=True)
class Column:
    """A column of a table: the name without its unit, and the unit in small letters."""

    index: int
    name: str
    unit: str = ""

    @property
    def words(self) -> Words:
        """Return the words of the name."""
        return words_of(self.name)

    @property
    def may_be_joint(self) -> bool:
        """True where it has a name, and no unit that no joint has."""
        return bool(self.words) and self.unit in {"", *SIZES}

    @property
    def aside(self) -> bool:
        """True where it counts or dates the rows, or has a unit that no joint has."""
        letters = list(filter(is_word, self.words))
        return not self.may_be_joint or (
            bool(letters) and all_match(WORDS["aside"], letters)
        )


def column_of(
    index: int,
    cell: str,
    below: str = "",
) -> Column:
    """Return the column that a header's cell names, and the cell below it where units stand."""
    name = cell
    unit = below.strip(" []()")
    match = _UNIT.fullmatch(cell)
    metres = _METRES.fullmatch(cell)
    degrees = _DEGREES.search(cell)
    if match and (match[3] is None or match[3].strip().lower() in _BEHIND):
        name = match[1]
        unit = match[2] or match[3] or match[4]
    elif metres:
        name = metres[1]
        unit = "m"
    elif not unit and degrees:
        unit = degrees[1]
    return Column(index, name, unit.strip().lower())


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
    file: Path,
    first: Line,
    others: Sequence[Line],
    names: set[str],
) -> tuple[str, ...] | None:
    """Return the names of columns in a first line; None where it is a sample.

    Raises:
        RecordingError: It is garbled.
    """
    line, cells = first
    header = tuple(cells)
    if names and names <= set(header):
        return header
    if header and all(map(GARBLED.fullmatch, header)):
        raise RecordingError(
            f"{file}:{line}: {header[0]!r} is neither a number nor the name of a joint; separate "
            "numbers by commas, as in 0.1,-1.5,2"
        )
    below = [row[: len(header)] for _, row in others[:_LOOKED_AT]]
    numbers = [i for i, cell in enumerate(header) if holds_number(cell)]
    if not numbers:
        return header if not below or any(map(count_numbers, below)) else None
    # Names that are numbers are whole ones, each once and one after the other, in any order.
    if len(numbers) < _NUMBERED or not all(header[i].isdecimal() for i in numbers):
        return None
    counts = sorted(int(header[i]) for i in numbers)
    if not below or counts != list(range(counts[0], counts[0] + len(counts))):
        return None
    for row in below:
        under = [row[i] for i in numbers if i < len(row)]
        if not any(map(_DECIMAL.search, filter(holds_number, under))):
            return None
    return header


def count_numbers(cells: Cells) -> int:
    """Return how many cells are numbers."""
    return sum(map(holds_number, cells))


def are_units(cells: Cells) -> bool:
    """Return whether a line holds units: no number, and at least one that is known."""
    units = {cell.strip(" []()").lower() for cell in cells}
    return not (count_numbers(cells) or units.isdisjoint({*SIZES, *OTHER_UNITS}))
