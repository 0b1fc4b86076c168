"""Files of known distances between sockets: words, one a line, or a table with units.

A table has these columns, in any order; ``deviation`` may be left out, ``#`` begins a note::

    from,to,distance [mm],deviation [mm]
    left:0,right:0,350.02,0.1
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from ...recorder import Column, RecordingError, Table, read_text, table_of
from .known import KnownDistance, KnownError, unit_of

ENDS, LENGTH, DEVIATION = ("from", "to"), "distance", "deviation"
_HEADER = "from,to,distance [mm],deviation [mm]"


def read_known(sources: Sequence[str | Path | KnownDistance]) -> Iterator[str | KnownDistance]:
    """Yield known distances, one by one; a word that is a file stands for its lines or rows.

    Raises:
        KnownError: A table without its columns or their units.
    """
    for source in sources:
        if isinstance(source, KnownDistance) or not Path(source).is_file():
            yield source if isinstance(source, KnownDistance) else str(source)
        else:
            yield from _words(Path(source))


def _words(file: Path) -> list[str]:
    """Return the distances of a file in words."""
    text = re.sub("#.*", "", read_text(file))
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines or "=" in lines[0] or not re.search("[,;\t]", lines[0]):
        return lines
    try:
        table = table_of(text, file)
    except RecordingError as error:
        raise KnownError(str(error)) from None
    first, second = [_column(table, name, file) for name in ENDS]
    lengths = [_column(table, LENGTH, file)]
    if any(column.name.lower().startswith(DEVIATION) for column in table.columns):
        lengths.append(_column(table, DEVIATION, file))
    scales = [unit_of(file, column, KnownError) for column in lengths]
    words: list[str] = []
    for line, cells in zip(table.lines, table.rows, strict=True):
        numbers: list[float] = []
        for column, scale in zip(lengths, scales, strict=True):
            try:
                numbers.append(scale * float(cells[column.index]))
            except ValueError:
                problem = f"{cells[column.index]!r:.40} is no length"
                raise KnownError(f"{file}:{line}: {problem}") from None
        ends = f"{cells[first.index].strip()}-{cells[second.index].strip()}"
        words.append(f"{ends}={'+-'.join(map(repr, numbers))}")
    return words


def _column(table: Table, name: str, file: Path) -> Column:
    """Return the column of a name."""
    columns = [column for column in table.columns if column.name.lower() == name]
    if len(columns) != 1:
        raise KnownError(f"{file}:1: column {name!r}: expected one; a header is {_HEADER}")
    return columns[0]
