"""Joint states as ROS prints them: each message a line, its joints' names among the cells.

``ros2 topic echo --csv /joint_states`` has no header, but sec, nanosec, frame_id, the names, and
as many positions; ``rostopic echo -p /joint_states`` has field.name0, .., field.position0, ..
"""

import re
from collections.abc import Sequence
from itertools import chain, takewhile

Record = tuple[int, list[str]]
"""Line, and its cells."""
_FIELD = re.compile(r"(?:.*\.)?(name|position)\[?(\d+)\]?")
_SECOND = 1_000_000_000


def named_states(records: Sequence[Record]) -> list[Record] | None:
    """Return messages as a table: time and the joints in the header, a position or nothing below.

    None where the records are no such messages.
    """
    first = [cell.strip() for cell in records[0][1]]
    matches = [_FIELD.fullmatch(cell) for cell in first]
    fields = {match.groups(): i for i, match in enumerate(matches) if match}
    numbered = len(first) > 4 and first[0].isdecimal() and first[1].isdecimal()
    if ("name", "0") in fields and ("position", "0") in fields:
        clock = next(
            (i for i, cell in enumerate(first) if cell.endswith("header.stamp")), 0
        )
        messages = [_by_fields(record, fields, clock) for record in records[1:]]
    elif numbered and _is_name(first[3]):
        messages = [_by_place(record) for record in records]
    else:
        return None
    names = list(
        dict.fromkeys(chain.from_iterable(positions for _, _, positions in messages))
    )
    table = [(records[0][0], ["time", *names])]
    for line, time, positions in messages:
        cells = [positions.get(name, "") for name in names]
        table.append((line, [time, *cells]))
    return table


def _by_fields(
    record: Record, fields: dict[tuple[str, ...], int], clock: int
) -> tuple[int, str, dict[str, str]]:
    """Return line, time [s] and positions of a message below a header of fields."""
    line, cells = record
    positions: dict[str, str] = {}
    for (kind, number), i in fields.items():
        if kind != "name":
            continue
        index = fields.get(("position", number), len(cells))
        if max(i, index) < len(cells) and cells[i].strip():
            positions[cells[i].strip()] = cells[index]
    stamp = cells[clock].strip()
    return line, _seconds(int(stamp)) if stamp.isdecimal() else "", positions


def _by_place(record: Record) -> tuple[int, str, dict[str, str]]:
    """Return the same of a message without a header."""
    line, cells = record
    texts = [cell.strip() for cell in cells]
    names = list(takewhile(_is_name, texts[3:]))
    begin = 3 + len(names)
    positions = texts[begin : begin + len(names)]
    dated = texts[0].isdecimal() and texts[1].isdecimal()
    if len(positions) < len(names) or not dated:
        return line, "", {}
    time = _seconds(int(texts[0]) * _SECOND + int(texts[1]))
    return line, time, dict(zip(names, positions, strict=True))


def _seconds(nanoseconds: int) -> str:
    return f"{nanoseconds // _SECOND}.{nanoseconds % _SECOND:09d}"


def _is_name(cell: str) -> bool:
    has_letter = any(map(str.isalpha, cell))
    return has_letter and cell.lower() not in ("nan", "inf", "-inf", ".nan")
