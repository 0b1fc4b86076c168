"""What a user may say of a table's columns, as far as the table itself tells."""

from collections.abc import Sequence

import numpy as np

from .columns import Column
from .coordinates import AXES
from .points import coordinates
from .recording_error import RecordingError
from .tables import Table

_LARGEST_ANGLE, _LARGEST_LENGTH = 6.5, 20.0
"""Larger numbers are degrees and millimetres [rad], [m]."""


def suggestion(table: Table) -> str:
    """Return what a user may say of a table's columns, as far as the table itself tells."""
    numeric = table.joints()
    place = place_of(table) or (numeric[-3:] if len(numeric) > len(AXES) else [])
    joints = [column for column in numeric if column not in place]
    names = [_called(table, column) for column in joints]
    if not table.header and names:
        names = [f"{names[0]}..{names[-1]}"]
    words = [
        f"'q={','.join(names)}{_unit(table, joints, _LARGEST_ANGLE, 'rad', 'deg')}'"
    ]
    for axis, column in zip(AXES, place, strict=False):
        unit = _unit(table, place, _LARGEST_LENGTH, "m", "mm")
        words.append(f"'{axis}={_called(table, column)}{unit}'")
    return f"--columns {' '.join(words)}"


def place_of(table: Table) -> list[Column] | None:
    """Return the columns of a place; None where there are none, or several arms'."""
    try:
        return coordinates(table, AXES)
    except RecordingError:
        return None


def _called(table: Table, column: Column) -> str:
    """Return what a user may call a column: its name, or its number where several have it."""
    names = [other.name for other in table.columns]
    is_clear = names.count(column.name) == 1 and column.name and "," not in column.name
    return column.name if is_clear else str(column.index + 1)


def _unit(
    table: Table, columns: Sequence[Column], largest: float, small: str, large: str
) -> str:
    """Return the unit of columns that name none, by how large their numbers are."""
    if not columns or any(column.unit for column in columns):
        return ""
    values = np.abs(np.array(table.numbers(columns, gaps=True)))
    return f" [{large if np.nanmax(values, initial=0.0) > largest else small}]"
