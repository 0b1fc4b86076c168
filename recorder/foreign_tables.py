"""Tables as other programs write them: text or a spreadsheet, joint states as ROS prints them."""

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import chain, takewhile
from pathlib import Path

from .cells import ZIP, read_text, table_bytes, trimmed
from .first_line import Line, are_units, count_numbers
from .spreadsheet import sheet_text
from .tables import Table, table_of


def read_table(file: Path, names: Collection[str] = ()) -> Table:
    """Read a file of cells as :func:`.table_of` does; of a spreadsheet the first sheet.

    Raises:
        RecordingError: The file is missing, empty, or no table.
    """
    content = table_bytes(file)
    if not content.startswith(ZIP):
        return foreign_table(read_text(file), file, names)
    text, sheets = sheet_text(content, file)
    table = foreign_table(text, file, names)
    if not sheets:
        return table
    remark = f"{file}: its first sheet is read; {', '.join(sheets):.60} is not"
    return replace(table, notes=(*table.notes, remark))


def foreign_table(text: str, file: Path, names: Collection[str] = ()) -> Table:
    """Return the cells of a text as :func:`read_table` does."""
    return table_of(
        text,
        file,
        names,
        lambda rows, text: one_heading(named_states(rows) or rows, text),
    )


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
    lines = text.splitlines()
    named = [
        (number, _named_by_blanks(lines[number - 1], cells, width))
        for number, cells in records[:MOST_LINES]
    ]
    top = list(takewhile(lambda record: not count_numbers(record[1]), named))
    below = list(records[len(top) :])
    if not (top and below):
        return list(records), []
    # A title is a text above several columns, with commas in it or behind it.
    heads = [
        (line, cells)
        for line, cells in top
        if len(cells) >= width and not width > 1 == len(trimmed(cells, 1))
    ]
    titles = [record for record in top if record not in heads]
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
        if not is_whole:  # names of groups, each repeated up to the next one
            for i in range(1, width):
                group[i] = group[i] or group[i - 1]
        names = [f"{a} {b}".strip() for a, b in zip(names, group, strict=True)]
        count += 1
        if is_whole:
            break
    left_out = [*titles, *heads[count:]]
    notes = [f"{line}: no names of columns, left out" for line, _ in left_out]
    return [(heads[0][0], names), *(units or []), *below], notes


def _named_by_blanks(line: str, cells: list[str], width: int) -> list[str]:
    """Return the names of a line in which blanks part the columns and stand in their names, too."""
    if len(cells) <= width or line.split() != cells:
        return cells
    joined = _BRACKETED.sub(r"\1", _NUMBERED.sub(r"\1_\2", line))
    for names in (joined.split(), _BLANKS.split(line.strip())):
        if len(names) == width:
            return names
    return cells


_FIELD = re.compile(r"(?:.*\.)?(name|position)\[?(\d+)\]?")
_SECOND = 1_000_000_000


Message = tuple[int, str, dict[str, str]]
"""A message of joint states: line, seconds or nothing, and cells by the joints' names."""


def named_states(records: Sequence[Line]) -> list[Line] | None:
    """Return messages as a table: time and the joints in the header, a position or nothing below.

    None where the records are no such messages.
    """
    messages = _messages(records)
    if messages is None:
        return None
    by_message = (positions for _, _, positions in messages)
    names = list(dict.fromkeys(chain.from_iterable(by_message)))
    table = [(records[0][0], ["time", *names])]
    for line, time, positions in messages:
        table.append((line, [time, *(positions.get(name, "") for name in names)]))
    return table


def _messages(records: Sequence[Line]) -> list[Message] | None:
    """Return the messages of some records; None where they are none."""
    first = [cell.strip() for cell in records[0][1]]
    matches = [_FIELD.fullmatch(cell) for cell in first]
    fields = {match.groups(): i for i, match in enumerate(matches) if match}
    if ("name", "0") in fields and ("position", "0") in fields:
        stamps = [i for i, cell in enumerate(first) if cell.endswith("header.stamp")]
        clock = stamps[0] if stamps else 0
        return [_by_fields(record, fields, clock) for record in records[1:]]
    dated = len(first) > 4 and first[0].isdecimal() and first[1].isdecimal()
    if dated and _is_name(first[3]):
        return [_by_place(record) for record in records]
    return None


def _by_fields(record: Line, fields: dict[tuple[str, ...], int], clock: int) -> Message:
    """Return a message below a header of fields."""
    line, cells = record
    count = len(cells)
    positions: dict[str, str] = {}
    for (kind, number), i in fields.items():
        index = fields.get(("position", number), count)
        if kind == "name" and max(i, index) < count and cells[i].strip():
            positions[cells[i].strip()] = cells[index]
    stamp = cells[clock].strip() if clock < count else ""
    return line, _seconds(int(stamp)) if stamp.isdecimal() else "", positions


def _by_place(record: Line) -> Message:
    """Return a message without a header."""
    line, cells = record
    texts = [cell.strip() for cell in cells]
    names = list(takewhile(_is_name, texts[3:]))
    positions = texts[3 + len(names) :]
    dated = texts[0].isdecimal() and texts[1].isdecimal()
    if len(positions) < len(names) or not dated:
        return line, "", {}
    nanoseconds = int(texts[0]) * _SECOND + int(texts[1])
    return line, _seconds(nanoseconds), dict(zip(names, positions, strict=False))


def _seconds(nanoseconds: int) -> str:
    seconds, fraction = divmod(nanoseconds, _SECOND)
    return f"{seconds}.{fraction:09d}"


def _is_name(cell: str) -> bool:
    has_letter = any(map(str.isalpha, cell))
    return has_letter and cell.lower() not in ("nan", "inf", "-inf", ".nan")
