"""A table of another program as a placement: its names, or a user, tell what the columns are."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from .columns import Column
from .coordinates import AXES, MATRIX, TURNS
from .joined_tables import joined_name, read_joined
from .markers import body_of, marker_columns
from .named_columns import NamedColumns, named_columns
from .placement import Placement
from .points import coordinates, placement_of_points, unit_quaternion
from .recording_error import RecordingError
from .sample import LAST_SOCKET, Sample
from .tables import Table

_LISTED = 8


def read_table_placement(
    path: Path, columns: Sequence[str] = (), on: str = ""
) -> Placement:
    """Return the placement of a table, or of several whose rows belong together.

    Args:
        path: A file, or several as in ``joints.csv+points.csv``.
        columns: Its columns, as :func:`.named_columns` reads them; none to find them by names.
        on: The column by which rows of several files belong together; empty for their order.

    Raises:
        RecordingError: A file is no table, or its columns are not told; the message says how.
    """
    table = read_joined(path, on)
    name = joined_name(path, table)
    if columns:
        placement = _placement(table, named_columns(table, columns), name)
    else:
        placement = _by_names(table, name)
    advice = suggestion(table)
    return replace(placement, files=(path,), is_table=True, suggestion=advice)


def _by_names(table: Table, name: str) -> Placement:
    """Return the placement of a table whose columns tell themselves."""
    if markers := marker_columns(table):
        return _of_markers(table, markers, name)
    try:
        return placement_of_points(table, name)
    except RecordingError as error:
        sockets = [c for c in table.columns if c.words == ("socket",)]
        if len(sockets) == 1:
            joints = table.joints(sockets)
            positions = np.array(table.numbers(joints, gaps=True))
            names = tuple(column.name for column in joints)
            numbers = {"q": positions, "socket": np.array(table.numbers(sockets))}
            return _placement(table, NamedColumns(numbers, names, ()), name)
        if place_of(table):
            raise
        raise RecordingError(
            f"{table.file}: no header tells its joints and x, y, z; say which columns they are, "
            f"here or by mukca convert, as in {suggestion(table)}"
        ) from error


def _of_markers(table: Table, columns: Sequence[Column], name: str) -> Placement:
    """Return the placement of a table with several markers on one flange."""
    markers = np.array(table.numbers(columns, gaps=True))
    numbers, misfit = body_of(markers.reshape(len(markers), -1, 3))
    named = NamedColumns(numbers, (), tuple(columns))
    placement = _placement(table, named, name)
    count = len(columns) // len(AXES)
    what = "its middle and its turn" if MATRIX[0] in numbers else "its middle"
    remark = (
        f"{table.file}: {count} markers are taken as one rigid body, by {what}; they keep its "
        f"shape to {1e3 * misfit:.2f} mm"
    )
    return replace(placement, remarks=(*placement.remarks, remark))


def _placement(table: Table, named: NamedColumns, name: str) -> Placement:
    """Return the placement of columns that are named; what is not named is found by names."""
    numbers = dict(named.numbers)
    names = named.joints
    if not set(AXES) & set(numbers) and "socket" not in numbers:
        place = place_of(table)
        if place is not None:
            xyz = np.array(table.numbers(place, gaps=True))
            numbers |= {axis: xyz[:, i : i + 1] for i, axis in enumerate(AXES)}
            named = replace(named, used=(*named.used, *place))
    is_measured = set(AXES) <= set(numbers)
    if "q" not in numbers and table.header:
        joints = table.joints(named.used)
        numbers["q"] = np.array(table.numbers(joints, gaps=True))
        names = tuple(column.name for column in joints)
    if "q" not in numbers or not (is_measured or "socket" in numbers):
        raise RecordingError(
            f"{table.file}: --columns: q is needed, and socket, or x, y and z; as in "
            f"{suggestion(table)}"
        )
    return _of_numbers(table, numbers, names if table.header else None, name)


def _of_numbers(
    table: Table,
    numbers: dict[str, np.ndarray],
    joint_names: tuple[str, ...] | None,
    name: str,
) -> Placement:
    """Return the placement of numbers by what they are; rows without a place are left out."""
    forms = [form for form in TURNS if set(form) <= set(numbers)]
    turn = forms[0] if forms else ()
    measured = [n for n in (*AXES, *turn) if n in numbers]
    samples: list[Sample] = []
    lost: list[int] = []
    for i in range(len(table.rows)):
        where = table.where(i)
        row = {key: tuple(values[i].tolist()) for key, values in numbers.items()}
        if measured and all(np.isnan(row[key]).all() for key in measured):
            lost.append(table.lines[i])
            continue
        for key in (*measured, "q", "socket"):
            if np.isnan(row.get(key, ())).any():
                raise RecordingError(f"{where}: {key} is no finite number")
        socket = row.get("socket", (0.0,))[0]
        if not 0 <= socket <= LAST_SOCKET or socket % 1:
            raise RecordingError(
                f"{where}: socket {socket:g} is no number from 0 to 999"
            )
        sample = Sample(row["q"], int(socket), row.get("effort"), where=where)
        if measured:
            x, y, z = [row[axis][0] for axis in AXES]
            sample = replace(sample, point=(x, y, z))
        if turn:
            angles = tuple(row[key][0] for key in turn)
            orientation = unit_quaternion(angles, turn, where)
            sample = replace(sample, turn=angles, orientation=orientation)
        samples.append(sample)
    if not samples:
        raise RecordingError(f"{table.file}: no row has numbers in these columns")
    notes = [*table.notes]
    if lost:
        lines = ", ".join(map(str, lost[:_LISTED])) + ", .." * (len(lost) > _LISTED)
        notes.append(
            f"{table.file}: {len(lost)} rows without a place are left out (lines {lines})"
        )
    return Placement(
        name=name,
        samples=tuple(samples),
        joint_names=joint_names,
        files=(table.file,),
        remarks=tuple(notes),
        poses_of="flange" if turn else None,
    )


_LARGEST_ANGLE, _LARGEST_LENGTH = 6.5, 20.0
"""Larger numbers are degrees and millimetres [rad], [m]."""


def suggestion(table: Table) -> str:
    """Return what a user may say of a table's columns, as far as the table itself tells."""
    numeric = table.joints()
    place = place_of(table) or (numeric[-3:] if len(numeric) > len(AXES) else [])
    joints = [c for c in numeric if c not in place and not _counts(table, c)]
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


def _counts(table: Table, column: Column) -> bool:
    """Return True for a column that counts the rows, whatever its name."""
    values = np.array(table.numbers([column], gaps=True))
    return len(values) > 2 and bool((np.diff(values, axis=0) == 1).all())


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
