"""Columns of a table as a user may name them, as far as names and numbers tell."""

from collections.abc import Sequence

import numpy as np

from .columns import Column
from .coordinates import (
    AXES,
    MAKERS,
    MATRIX,
    QUATERNION,
    TURNS,
    match_coordinates,
    place_of,
)
from .joint_columns import OTHER, ColumnError, series_of
from .tables import Table
from .words import PENDANTS, words_of

_LARGEST_ANGLE, _LARGEST_LENGTH = 6.5, 20.0
"""Larger numbers are degrees and millimetres [rad], [m]."""
_UNIT = 1e-3
"""Deviation from 1 of the lengths of rotations, as tables round them."""


def suggestion(table: Table, count: int = 0) -> str:
    """Return what a user may say of the columns of a table.

    Args:
        table: A table.
        count: Number of the robot's joints; 0 where no robot is known yet.
    """
    columns = [c for c in table.columns if not table.is_text(c.index)]
    place = place_of(columns)
    columns = [c for c in columns if not _is_counter(table, c)]
    joints = _joints_by_name(columns, count)
    others = [c for c in columns if c not in (*joints, *place)]
    others = [
        c
        for c in others
        if not (c.name and c.aside) and not any(map(OTHER.fullmatch, c.words))
    ]
    if not joints:
        joints = others[: count or _without_pose(table, others, bool(place))]
    others = [c for c in others if c not in joints]
    place, turn, columns_of_turn = _pose(table, place, others)
    words = [
        f"'q={_names(table, joints)}{_unit(table, joints, _LARGEST_ANGLE, 'rad', 'deg')}'"
    ]
    for axis, column in zip(AXES, place, strict=False):
        unit = _unit(table, place, _LARGEST_LENGTH, "m", "mm")
        words.append(f"'{axis}={_called(table, column)}{unit}'")
    for name, column in zip(turn, columns_of_turn, strict=True):
        unit = (
            _unit(table, columns_of_turn, _LARGEST_ANGLE, "rad", "deg")
            if len(turn) == 3
            else ""
        )
        words.append(f"'{name}={_called(table, column)}{unit}'")
    return f"--columns {' '.join(words)}"


def _joints_by_name(columns: Sequence[Column], count: int) -> list[Column]:
    """Return the columns called like numbered joints, or like a pendant's; none without them."""
    names = [c.name for c in columns]
    for pendant in PENDANTS:
        words = [" ".join(words_of(name)) for name in names]
        if all(words.count(joint) == 1 for joint in pendant):
            return [columns[words.index(joint)] for joint in pendant]
    sizes = (count,) if count else (7, 6, 8, 5, 4, 9, 10, 3)
    series = list(series_of(names).values()) or list(
        series_of(_without_others(names)).values()
    )
    for size in sizes:
        for joints in series:
            if len(joints) == size:
                return [columns[joints[k][0]] for k in range(size)]
    return []


def _without_others(names: Sequence[str]) -> list[str]:
    """Return names without the words of commands, where nothing else tells of joints."""
    words = [[w for w in words_of(name) if not OTHER.fullmatch(w)] for name in names]
    return [" ".join(kept) for kept in words]


def _without_pose(table: Table, columns: Sequence[Column], has_place: bool) -> int:
    """Return how many of some columns stand before the place and the turn, by their numbers."""
    if has_place:
        return len(columns)
    ends = (12, 7, 3)
    for end in ends:
        if len(columns) > end and (end == 3 or _turn_within(table, columns[-end:])):
            return len(columns) - end
    return len(columns)


def _turn_within(table: Table, columns: Sequence[Column]) -> tuple[str, ...]:
    """Return the names of columns that are a place and a rotation by their numbers, in order."""
    values = np.array(table.numbers(columns, gaps=True))
    if len(columns) == 7:
        lengths = np.linalg.norm(values[:, 3:], axis=1)
        is_turn = bool(np.nanmax(np.abs(lengths - 1), initial=0.0) < _UNIT)
        return (*AXES, *QUATERNION) if is_turn else ()
    for names in (_BY_ROWS, (*AXES, *MATRIX), (*MATRIX, *AXES)):
        R = values[:, [names.index(name) for name in MATRIX]].reshape(-1, 3, 3)
        squares = np.einsum("nij,nkj->nik", R, R) - np.eye(3)
        if np.nanmax(np.abs(squares), initial=0.0) < _UNIT:
            return names
    return ()


_BY_ROWS = tuple(n for i in range(3) for n in (*MATRIX[3 * i : 3 * i + 3], AXES[i]))
"""Rows of a homogeneous matrix."""


def _pose(
    table: Table, place: Sequence[Column], others: Sequence[Column]
) -> tuple[Sequence[Column], tuple[str, ...], list[Column]]:
    """Return the columns of a place, and names and columns of its turn, where there is one."""
    if place:
        for form in TURNS:
            try:
                named = match_coordinates(others, form)
            except ColumnError:
                named = None
            if named and (len(form) != 3 or named[0].unit or set(form) <= MAKERS):
                return place, form, named
        if len(others) == 4 and _turn_within(table, [*place, *others]):
            return place, ("qw", "qx", "qy", "qz"), list(others)
        return place, (), []
    for size in (12, 7):
        names = _turn_within(table, others[:size]) if len(others) >= size else ()
        if names:
            by_name = dict(zip(names, others, strict=False))
            turn = tuple(n for n in names if n not in AXES)
            return [by_name[a] for a in AXES], turn, [by_name[n] for n in turn]
    return others[:3], (), []


def _is_counter(table: Table, column: Column) -> bool:
    """Return True for a column that counts the rows, whatever its name."""
    values = np.array(table.numbers([column], gaps=True))
    return len(values) > 2 and bool((np.diff(values, axis=0) == 1).all())


def _names(table: Table, columns: Sequence[Column]) -> str:
    """Return what a user may call several columns: a range where their numbers follow."""
    names = [_called(table, column) for column in columns]
    numbers = [column.index + 1 for column in columns]
    is_range = len(names) > 1 and numbers == list(
        range(numbers[0], numbers[0] + len(names))
    )
    if is_range and names == list(map(str, numbers)):
        return f"{names[0]}..{names[-1]}"
    return ",".join(names)


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


def turn_advice(table: Table) -> str:
    """Return what a user may say to read a quaternion that no name tells; empty without one."""
    advice = suggestion(table)
    return advice if "'qw=" in advice else ""
