"""Tables as other programs write them: text or a spreadsheet, joint states as ROS prints them."""

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import chain, takewhile
from pathlib import Path

from .cells import ZIP, read_text, table_bytes
from .columns import Line
from .headings import one_heading
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
    remark = (
        f"{file}: its largest sheet is read; {', '.join(sheets):.60} is not; if joints and points "
        "are apart, save both as CSV, and give JOINTS.csv+POINTS.csv"
    )
    return replace(table, notes=(*table.notes, remark))


def foreign_table(
    text: str,
    file: Path,
    names: Collection[str] = (),
) -> Table:
    """Return the cells of a text as :func:`read_table` does."""
    return table_of(
        text,
        file,
        names,
        lambda rows, text: one_heading(named_states(rows) or rows, text, file),
    )


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
    first = records[0][1]
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


def _by_fields(
    record: Line,
    fields: dict[tuple[str, ...], int],
    clock: int,
) -> Message:
    """Return a message below a header of fields."""
    line, cells = record
    count = len(cells)
    positions: dict[str, str] = {}
    for (kind, number), i in fields.items():
        index = fields.get(("position", number), count)
        if kind == "name" and max(i, index) < count and cells[i]:
            positions[cells[i]] = cells[index]
    stamp = cells[clock] if clock < count else ""
    return line, _seconds(int(stamp)) if stamp.isdecimal() else "", positions


def _by_place(record: Line) -> Message:
    """Return a message without a header."""
    line, texts = record
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
