"""Lines above the first numbers of a table made one: titles, groups of columns, names, remarks."""

import re
from collections.abc import Sequence
from itertools import takewhile

from .cells import trimmed
from .first_line import Line, are_units, count_numbers

MOST_LINES = 8
"""Most lines of words above the first numbers."""
_BLANKS = re.compile(r"\s{2,}|\t")
_NUMBERED = re.compile(r"([^\W\d]+)\s+(\d+)\b")
"""A name and its number, which a blank parts as it does names."""
_BRACKETED = re.compile(r"\s+([\[(][^\])]*[\])])")


def one_heading(records: Sequence[Line], text: str) -> tuple[list[Line], list[str]]:
    """Return records with one line of names at most, units below it, and remarks on the others.

    A name of a group stands for the columns up to the next one, before their own names. Of several
    whole lines of names the first one counts. A text with one separated word is a title.
    """
    width = len(records[:MOST_LINES][-1][1])
    lines = [text.splitlines()[line - 1] for line, _ in records[:MOST_LINES]]
    named = [
        (number, _named_by_blanks(line, cells, width))
        for line, (number, cells) in zip(lines, records, strict=False)
    ]
    top = list(takewhile(lambda record: not count_numbers(record[1]), named))
    below = list(records[len(top) :])
    if not (top and below):
        return list(records), []
    titles = [(line, cells) for line, cells in top if _is_title(cells, width)]
    heads = [record for record in top if record not in titles]
    units = heads[1:] and are_units(heads[-1][1]) and [heads.pop()]
    if not heads or (len(heads) == 1 and not titles):
        return [*top, *below], []
    if any(len(trimmed(cells, width)) != width for _, cells in heads):
        return list(records), []
    names = [""] * width
    count = 0
    for _, cells in heads:
        group = [cell.strip() for cell in trimmed(cells, width)]
        is_whole = all(group) and len(set(group)) == width
        group = group if is_whole else _spread(group)
        names = [f"{a} {b}".strip() for a, b in zip(names, group, strict=True)]
        count += 1
        if is_whole:
            break
    left_out = [*titles, *heads[count:]]
    notes = [f"{line}: no names of columns, left out" for line, _ in left_out]
    return [(heads[0][0], names), *(units or []), *below], notes


def _is_title(cells: Sequence[str], width: int) -> bool:
    """Return whether a line is a text above several columns, with commas in it or behind it."""
    return len(cells) < width or width > 1 == len(trimmed(cells, 1))


def _spread(group: Sequence[str]) -> list[str]:
    """Return names of groups, each repeated up to the next one."""
    names = [""]
    for cell in group:
        names.append(cell or names[-1])
    return names[1:]


def _named_by_blanks(line: str, cells: list[str], width: int) -> list[str]:
    """Return the names of a line in which blanks part the columns and stand in their names, too."""
    if len(cells) <= width or line.split() != cells:
        return cells
    joined = _BRACKETED.sub(r"\1", _NUMBERED.sub(r"\1_\2", line))
    for names in (joined.split(), _BLANKS.split(line.strip())):
        if len(names) == width:
            return names
    return cells
