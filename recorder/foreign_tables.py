"""Tables as other programs write them: text or a spreadsheet, joint states as ROS prints them."""

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from .cells import ZIP, read_text, table_bytes
from .first_line import Line
from .heading import one_heading
from .ros_text import named_states
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
    return table_of(text, file, names, _arranged)


def _arranged(records: list[Line], text: str) -> tuple[list[Line], list[str]]:
    return one_heading(named_states(records) or records, text)
