"""Files of known distances between sockets: words, one a line, or a table with units.

A table has the columns ``from,to,distance [mm],deviation [mm]``, the last of which may be left out;
see :mod:`.length_table`.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from .known import KnownDistance, KnownError
from .length_table import read_lengths, text_without_notes


def read_known(
    sources: Sequence[str | Path | KnownDistance],
) -> Iterator[str | KnownDistance]:
    """Yield known distances, one by one; a word that is a file stands for its lines or rows.

    Raises:
        KnownError: A table without its columns or their units.
    """
    for source in sources:
        if isinstance(source, KnownDistance):
            yield source
        elif Path(source).is_file():
            yield from _words(Path(source))
        else:
            yield str(source)


def _words(file: Path) -> Iterator[str]:
    """Yield the distances of a file in words."""
    text = text_without_notes(file)
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines or "=" in lines[0] or not re.search("[,;\t]", lines[0]):
        yield from lines
        return
    lengths = (
        ["distance", "deviation"] if "deviation" in lines[0].lower() else ["distance"]
    )
    for _, (first, second), values in read_lengths(
        file, ["from", "to"], lengths, KnownError
    ):
        yield f"{first}-{second}={'+-'.join(map(repr, values))}"
