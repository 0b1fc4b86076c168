"""A table of another program as a placement: its names, or a user, tell what the columns are."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from .coordinates import AXES, MATRIX, TURNS, place_of
from .joined_tables import joined_name, read_joined
from .markers import body_of, marker_columns
from .named_columns import NamedColumns, named_columns
from .placement import Placement
from .points import placement_of_points, unit_quaternion
from .recording_error import NoColumnsError, RecordingError, UnitError
from .sample import LAST_SOCKET, Sample
from .suggestion import suggestion, turn_advice
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
        named = named_columns(table, columns)
        placement = _placement(table, named, name)
        placement = replace(placement, told=bool(named.joints))
    else:
        placement = _by_names(table, name)
        if placement.samples[0].orientation is None and (advice := turn_advice(table)):
            what = "four columns have length 1, as a quaternion; it is read by"
            words = f"{table.file}: {what} {advice}"
            placement = replace(placement, remarks=(*placement.remarks, words))
    return replace(placement, files=(path,), suggestion=partial(suggestion, table))


def _by_names(table: Table, name: str) -> Placement:
    """Return the placement of a table whose columns tell themselves."""
    if marker_columns(table):
        return _placement(table, NamedColumns({}, (), ()), name)
    try:
        return placement_of_points(table, name)
    except UnitError:
        raise
    except RecordingError as error:
        sockets = [c for c in table.columns if c.words == ("socket",)]
        if len(sockets) == 1:
            joints = table.joints(sockets)
            positions = np.array(table.numbers(joints, gaps=True))
            names = tuple(column.name for column in joints)
            numbers = {"q": positions, "socket": np.array(table.numbers(sockets))}
            return _placement(table, NamedColumns(numbers, names, ()), name)
        words = f"{error}; or say which columns they are"
        if isinstance(error, NoColumnsError):
            lacking = "no header tells its joints and x, y, z"
            words = f"{table.file}: {lacking}; say which columns they are"
        raise RecordingError(
            f"{words}, here or by mukca convert, as in {suggestion(table)}"
        ) from error


def _of_markers(table: Table, named: NamedColumns, name: str) -> Placement:
    """Return the placement of a table with several markers on one flange."""
    columns = marker_columns(table)
    markers = np.array(table.numbers(columns, gaps=True))
    numbers, misfit = body_of(markers.reshape(len(markers), -1, 3))
    used = (*named.used, *columns)
    named = NamedColumns({**named.numbers, **numbers}, named.joints, used)
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
    is_placed = set(AXES) & set(numbers) or "socket" in numbers
    if not is_placed and marker_columns(table):
        return _of_markers(table, named, name)
    if not is_placed and (place := place_of(table.columns)):
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
