"""Lines above the numbers of a table: titles, names of groups, names of columns, and units.

Programs of trackers and of motion capture write many: what was measured, by what, how often.
"""

import re
from collections import Counter
from collections.abc import Sequence
from itertools import product
from pathlib import Path

from .cells import Cells, holds_number, trimmed
from .columns import Line, are_units, count_numbers
from .recording_error import RecordingError

MOST_LINES = 40
"""Most lines above the first numbers."""
_NAMED = 1 / 3
"""A line of names has words above a larger share of the columns of numbers."""
_BLANKS = re.compile(r"\s{2,}|\t")
_NUMBERED = re.compile(r"([^\W\d]+)\s+(\d+)\b")
"""A name and its number, which a blank parts as it does names."""
_BRACKETED = re.compile(r"\s+([\[(][^\])]*[\])])")
_GROUP = re.compile(r"(.*?)(\s*[\[(][^\])]*[\])])?")
"""Name of a group, and the unit of all its columns."""


def one_heading(
    records: Sequence[Line], text: str, file: Path
) -> tuple[list[Line], list[str]]:
    """Return records and remarks as :func:`_arranged` does.

    Raises:
        RecordingError: What stands first is a title, or does not name all columns.
    """
    arranged, remarks = _arranged(records, text)
    _refuse_title(text, file, arranged)
    return arranged, remarks


def _arranged(records: Sequence[Line], text: str) -> tuple[list[Line], list[str]]:
    """Return records with one line of names at most, units below it, and remarks on the others.

    A name of a group stands for the columns up to the next one, before their own names. Of several
    whole lines of names the first one counts. A text with one separated word is a title. Below the
    names, a line without any number is a note.
    """
    later = records[len(records) // 2 :]
    ((width, _),) = Counter(len(cells) for _, cells in later).most_common(1)
    row = max((cells for _, cells in later), key=count_numbers)
    start = _first_row(records, row, width)
    lines = text.splitlines()
    top = [
        (line, _named_by_blanks(lines[line - 1], cells, width))
        for line, cells in records[:start]
    ]
    below = [record for record in records[start:] if not _is_note(record[1])]
    if not any(count_numbers(cells) for _, cells in below):
        return list(records), []
    notes = [record for record in records[start:] if record not in below]
    heads = [record for record in top if _is_head(record[1], row, width)]
    titles = [record for record in top if record not in heads]
    if _lacks_names(heads, titles, width):
        return list(records), []
    units = [heads.pop()] if heads[1:] and are_units(heads[-1][1]) else []
    heading = heads or _capture_names(titles, width)
    if len(heads) > 1 or (heads and titles):
        count, names = _joined_names([cells for _, cells in heads], width)
        heading = [(heads[0][0], _named_capture(names, titles))]
        titles += heads[count:]
    elif titles and not heading:
        return list(records), []
    remarks = [*_left_out(titles, "names of columns"), *_left_out(notes, "numbers")]
    return [*heading, *units, *below], remarks


def _first_row(records: Sequence[Line], row: Cells, width: int) -> int:
    """Return where the numbers begin; a line close above names is none of them."""
    for i, (_, cells) in enumerate(records[:MOST_LINES]):
        if not count_numbers(cells) or len(trimmed(cells, width)) != width:
            continue
        farthest = MOST_LINES if _words_above(cells, row) else i + 3
        above = [cells for _, cells in records[:i]]
        heads = [c for _, c in records[i:farthest] if _names(c, row, width)]
        if all(
            head in above for head in heads
        ):  # repeated, as by programs started twice
            return i
    return 0


def _words_above(cells: Cells, row: Cells) -> list[str]:
    """Return the words that stand where a row has numbers."""
    pairs = zip(cells, row, strict=False)
    return [c for c, n in pairs if c and holds_number(n) and not holds_number(c)]


def _is_note(cells: Cells) -> bool:
    """Return whether all cells with something have a letter, and none is a number."""
    filled = filter(None, cells)
    return not count_numbers(cells) and all(any(map(str.isalpha, c)) for c in filled)


def _names(cells: Cells, row: Cells, width: int) -> bool:
    """Return whether cells are words where a row has numbers."""
    is_whole = len(trimmed(cells, width)) == width
    return is_whole and len(_words_above(cells, row)) > max(
        1, _NAMED * count_numbers(row)
    )


def _is_head(cells: Cells, row: Cells, width: int) -> bool:
    """Return whether a line above the numbers names columns, or groups of them."""
    # A title is a text above several columns, with commas in it or behind it.
    is_title = width > 1 == len(trimmed(cells, 1))
    is_wide = len(cells) >= width and not is_title
    numbers = list(filter(holds_number, cells))
    is_counted = all(map(str.isdecimal, numbers)) and _names(cells, row, width)
    return is_wide and (not numbers or is_counted)


def _lacks_names(heads: Sequence[Line], titles: Sequence[Line], width: int) -> bool:
    """Return whether a line names more columns than there are, or is a row that is broken."""
    last = heads[-1][0] if heads else 0
    rows = [cells for line, cells in titles if line > last and count_numbers(cells)]
    is_broken = any(heads or holds_number(cells[0]) for cells in rows)
    return is_broken or any(len(trimmed(cells, width)) != width for _, cells in heads)


def _joined_names(heads: Sequence[list[str]], width: int) -> tuple[int, list[str]]:
    """Return how many lines name the columns, and the names."""
    names = [""] * width
    for count, cells in enumerate(heads, start=1):
        group = list(trimmed(cells, width))
        if all(group) and len(set(group)) == width:
            return count, list(map(_in_group, names, group))
        if count < len(heads) or count == 1:  # repeated up to the next one
            for i in range(1, width):
                group[i] = group[i] or group[i - 1]
        names = list(map(_in_group, names, group))
    return len(heads), names


def _in_group(group: str, name: str) -> str:
    """Return the name of a column of a group, with the unit of the group behind it."""
    match = _GROUP.fullmatch(group)
    words, unit = match.groups("") if match else (group, "")
    unit = "" if _BRACKETED.search(f" {name}") else unit
    return f"{words} {name}{unit}".strip()


def _named_by_blanks(line: str, cells: list[str], width: int) -> list[str]:
    """Return the names of a line in which blanks part the columns and stand in their names, too."""
    if len(cells) <= width or line.split() != cells:
        return cells
    joined = _BRACKETED.sub(r"\1", _NUMBERED.sub(r"\1_\2", line))
    for names in (joined.split(), _BLANKS.split(line.strip())):
        if len(names) == width:
            return names
    return cells


def _left_out(records: Sequence[Line], what: str) -> list[str]:
    """Return one remark on lines that lack something."""
    if not records:
        return []
    lines = [line for line, _ in records]
    others = f", nor in {len(lines) - 1} other lines" if lines[1:] else ""
    return [f"{lines[0]}: no {what}{others}, left out"]


def _refuse_title(text: str, file: Path, records: Sequence[Line]) -> None:
    """Refuse a first line of words that is a title, or does not name all columns below it.

    Raises:
        RecordingError: Each line below has more cells, or is not parted by the same separator.
    """
    (line, words), *others = records
    widths = {len(trimmed(cells, len(words))) for _, cells in others}
    has_width = len(widths) == 1 and len(words) not in widths
    no_header = has_width and (min(widths) == 1 or len(words) < min(widths))
    # Spreadsheets pad a title with separators.
    size = len(trimmed(words, 1))
    nameless = [cells[size : len(words)] for _, cells in others[:MOST_LINES]]
    is_text = words[0] and not holds_number(words[0])
    is_padded = is_text and max(map(count_numbers, nameless), default=0) > size
    if is_padded or (no_header and not count_numbers(words)):
        title = text.splitlines()[line - 1].strip(" ,;\t")
        raise RecordingError(
            f"{file}:{line}: {title!r:.60} is no header of the lines below it, which have another "
            "number of columns; name each column, or begin the line with #"
        )


_ROTATION = re.compile(r"(.*?)rot\[(\d)\]", re.IGNORECASE)
_ANGLE = re.compile(r".*\b(roll|pitch|yaw)", re.IGNORECASE)
_PLACE = re.compile(r"(.*\W)?[xyz]", re.IGNORECASE)
"""Columns of motion capture: TSV of Qualisys, CSV of OptiTrack and Vicon.

Qualisys names markers above the numbers. Of a rigid body it has R = Rx(roll) Ry(pitch) Rz(yaw), and
R itself by columns, Rot[0] to Rot[8], which is read.
"""


def _capture_names(titles: Sequence[Line], width: int) -> list[Line]:
    """Return the names of markers' coordinates as one line; none where no title names them."""
    for line, cells in titles:
        markers = list(filter(None, cells[1:]))
        names = [f"{name} {axis}" for name, axis in product(markers, "XYZ")]
        beside = width - len(names)
        if cells[0] == "MARKER_NAMES" and beside in (0, 2):
            names = ["Frame", "Time"][:beside] + names
            return [(line, _named_capture(names, titles))]
    return []


def _named_capture(names: Sequence[str], titles: Sequence[Line]) -> list[str]:
    """Return names with the unit of places that titles above them tell, and a body's rotation."""
    facts: dict[str, str] = {}
    for _, cells in titles:
        facts |= dict(zip(cells, [*cells[1:], ""], strict=True))
    unit = "mm" if "NO_OF_CAMERAS" in facts else facts.get("Length Units", "")
    rotations = [_ROTATION.fullmatch(name) for name in names]
    if "BODY_NAMES" not in facts:
        rotations = [None] * len(names)
    named: list[str] = []
    for name, match in zip(names, rotations, strict=True):
        if match:
            column, row = divmod(int(match[2]), 3)
            name = f"{match[1]}r{row + 1}{column + 1}"
        elif any(rotations) and _ANGLE.fullmatch(name):
            name = f"{name} angle"
        elif unit and _PLACE.fullmatch(name) and "rotation" not in name.lower():
            name = f"{name} [{unit}]"
        named.append(name)
    return named
