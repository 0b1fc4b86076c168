"""Columns of a table as a user may name them, as far as names and numbers tell."""

from collections.abc import Sequence
from contextlib import suppress

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
from .markers import marker_columns
from .tables import Table
from .words import PENDANTS, any_match, words_of

_ANGLES, _LENGTHS = (6.5, "rad", "deg"), (20.0, "m", "mm")
"""Largest number of the first unit; larger ones are of the second."""
_UNIT = 1e-3
"""Deviation from 1 of the lengths of rotations, as tables round them."""


def suggestion(table: Table, count: int = 0) -> str:
    """Return what a user may say of the columns of a table.

    Args:
        table: A table.
        count: Number of the robot's joints; 0 where no robot is known yet.
    """
    markers = marker_columns(table)
    columns = table.numeric(markers)
    place = place_of(columns)
    columns = [c for c in columns if c not in place and not _is_counter(table, c)]
    joints = _joints_by_name(columns, count)
    others = [c for c in columns if c not in joints and _tells(c)]
    if not joints:
        size = count or (len(others) if place else _before_pose(table, others))
        joints = others[:size]
        others = others[size:]
    turn: dict[str, Column] = {}
    if not markers:
        place, turn = _pose(table, place, others)
    words = [f"'q={_names(table, joints)}{_unit(table, joints, _ANGLES)}'"]
    of_place = dict(zip(AXES, place, strict=False))
    angles = list(turn.values()) if len(turn) == len(AXES) else []
    for by_name, unit in (
        (of_place, _unit(table, place, _LENGTHS)),
        (turn, _unit(table, angles, _ANGLES)),
    ):
        words += [f"'{name}={_called(table, c)}{unit}'" for name, c in by_name.items()]
    return f"--columns {' '.join(words)}"


def _tells(column: Column) -> bool:
    """Return whether a column may be a joint's or a coordinate, by its name if it has one."""
    is_aside = column.name and column.aside
    return not (is_aside or any_match(OTHER, column.words))


def _joints_by_name(columns: Sequence[Column], count: int) -> list[Column]:
    """Return the columns called like a pendant's joints, or numbered ones; none without them."""
    words = [column.words for column in columns]
    for pendant in map(list, sorted(PENDANTS, key=len, reverse=True)):
        joints = list(map(words_of, pendant))
        if all(words.count(joint) == 1 for joint in joints):
            return [columns[words.index(joint)] for joint in joints]
    names = [" ".join(name) for name in words]
    without_commands = [" ".join(w for w in n if not OTHER.fullmatch(w)) for n in words]
    for called in names, without_commands:
        series = [s for s in series_of(called).values() if len(s) in (count or len(s),)]
        if series:
            joints = max(series, key=len)
            return [columns[joints[k][0]] for k in range(len(joints))]
    return []


def _before_pose(table: Table, columns: Sequence[Column]) -> int:
    """Return how many of some columns stand before the place and the turn, by their numbers."""
    count = len(columns)
    for end in (12, 7):
        if count > end and _turn_within(table, columns[-end:]):
            return count - end
    return count - 3 if count > 3 else count


def _turn_within(table: Table, columns: Sequence[Column]) -> tuple[str, ...]:
    """Return the names of columns that are a place and a rotation by their numbers, in order."""
    values = table.array(columns)
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
    table: Table,
    place: list[Column],
    others: list[Column],
) -> tuple[list[Column], dict[str, Column]]:
    """Return the columns of a place, and those of its turn by name, where there is one."""
    if not place:
        for size in (12, 7):
            names = _turn_within(table, others[:size]) if len(others) >= size else ()
            by_name = dict(zip(names, others, strict=False))
            if names:
                return [by_name.pop(axis) for axis in AXES], by_name
        return others[:3], {}
    for form in TURNS:
        with suppress(ColumnError):
            named = match_coordinates(others, form) or []
            if named and (len(form) != 3 or named[0].unit or set(form) <= MAKERS):
                return place, dict(zip(form, named, strict=True))
    if len(others) == 4 and _turn_within(table, [*place, *others]):
        return place, dict(zip(("qw", "qx", "qy", "qz"), others, strict=True))
    return place, {}


def _is_counter(table: Table, column: Column) -> bool:
    """Return True for a column that counts the rows, whatever its name."""
    values = table.array([column])
    return len(values) > 2 and bool((np.diff(values, axis=0) == 1).all())


def _names(table: Table, columns: Sequence[Column]) -> str:
    """Return what a user may call several columns: a range where their numbers follow."""
    names = [_called(table, column) for column in columns]
    numbers = [column.index + 1 for column in columns]
    if names == list(map(str, numbers)) and set(np.diff(numbers)) == {1}:
        return f"{names[0]}..{names[-1]}"
    return ",".join(names)


def _called(table: Table, column: Column) -> str:
    """Return what a user may call a column: its name, or its number where several have it."""
    names = [other.name for other in table.columns]
    is_clear = names.count(column.name) == 1 and column.name and "," not in column.name
    return column.name if is_clear else str(column.index + 1)


def _unit(
    table: Table,
    columns: Sequence[Column],
    units: tuple[float, str, str],
) -> str:
    """Return the unit of columns that name none, by how large their numbers are."""
    if not columns or any(column.unit for column in columns):
        return ""
    largest, small, large = units
    number = np.nanmax(np.abs(table.array(columns)), initial=0.0)
    return f" [{large if number > largest else small}]"


def turn_advice(table: Table) -> str:
    """Return what a user may say to read a quaternion that no name tells; empty without one."""
    advice = suggestion(table)
    return advice if "'qw=" in advice else ""
