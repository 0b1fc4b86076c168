"""Joint states as ROS prints them: each message a line, its joints' names among the cells.

``ros2 topic echo --csv /joint_states`` has no header, but sec, nanosec, frame_id, the names, and
as many positions; ``rostopic echo -p /joint_states`` has field.name0, .., field.position0, ..
"""

import re
from collections.abc import Sequence
from itertools import chain, takewhile
from typing import NamedTuple

Record = tuple[int, list[str]]
"""Line, and its cells."""
_FIELD = re.compile(r"(?:.*\.)?(name|position)\[?(\d+)\]?")
_SECOND = 1_000_000_000


class _Message(NamedTuple):
    """A message of joint states."""

    line: int
    time: str
    """Seconds; empty where it has no stamp."""
    positions: dict[str, str]
    """Cells by the names of joints."""


def named_states(records: Sequence[Record]) -> list[Record] | None:
    """Return messages as a table: time and the joints in the header, a position or nothing below.

    None where the records are no such messages.
    """
    messages = _messages(records)
    if messages is None:
        return None
    by_message = (message.positions for message in messages)
    names = list(dict.fromkeys(chain.from_iterable(by_message)))
    first_line, _ = records[0]
    table = [(first_line, ["time", *names])]
    for message in messages:
        cells = [message.positions.get(name, "") for name in names]
        table.append((message.line, [message.time, *cells]))
    return table


def _messages(records: Sequence[Record]) -> list[_Message] | None:
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


def _by_fields(
    record: Record, fields: dict[tuple[str, ...], int], clock: int
) -> _Message:
    """Return a message below a header of fields."""
    line, cells = record
    positions: dict[str, str] = {}
    for (kind, number), i in fields.items():
        if kind != "name":
            continue
        index = fields.get(("position", number), len(cells))
        if max(i, index) < len(cells) and cells[i].strip():
            positions[cells[i].strip()] = cells[index]
    stamp = cells[clock].strip() if clock < len(cells) else ""
    time = _seconds(int(stamp)) if stamp.isdecimal() else ""
    return _Message(line, time, positions)


def _by_place(record: Record) -> _Message:
    """Return a message without a header."""
    line, cells = record
    texts = [cell.strip() for cell in cells]
    names = list(takewhile(_is_name, texts[3:]))
    begin = 3 + len(names)
    positions = texts[begin : begin + len(names)]
    dated = texts[0].isdecimal() and texts[1].isdecimal()
    if len(positions) < len(names) or not dated:
        return _Message(line, "", {})
    nanoseconds = int(texts[0]) * _SECOND + int(texts[1])
    by_name = dict(zip(names, positions, strict=True))
    return _Message(line, _seconds(nanoseconds), by_name)


def _seconds(nanoseconds: int) -> str:
    seconds, fraction = divmod(nanoseconds, _SECOND)
    return f"{seconds}.{fraction:09d}"


def _is_name(cell: str) -> bool:
    has_letter = any(map(str.isalpha, cell))
    return has_letter and cell.lower() not in ("nan", "inf", "-inf", ".nan")
