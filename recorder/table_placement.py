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
from .points import POINTS, POSES, measured_sample, placement_of_points
from .recording_error import NoColumnsError, RecordingError, UnitError, listed
from .sample import LAST_SOCKET, Sample
from .suggestion import suggestion, turn_advice
from .tables import Table


def read_table_placement(
    path: Path,
    columns: Sequence[str] = (),
    on: str = "",
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
            numbers = {"socket": np.array(table.numbers(sockets))}
            return _placement(table, NamedColumns(numbers, (), (*sockets,)), name)
        words = f"{error}; or say which columns they are"
        if isinstance(error, NoColumnsError) and table.file.name not in (POINTS, POSES):
            lacking = "no header tells its joints and x, y, z"
            read = "; ".join((f"{table.file}: {lacking}", *table.notes))
            words = f"{read}; say which columns they are"
        raise RecordingError(
            f"{words}, here or by mukca convert, as in {suggestion(table)}"
        ) from error


def _place_by_names(table: Table) -> tuple[NamedColumns, list[str]]:
    """Return the columns of a place, or those of markers on one flange, and a remark on these."""
    columns = marker_columns(table)
    if not columns:
        columns = place_of(table.columns)
        xyz = table.array(columns).T[:, :, None]
        return NamedColumns(dict(zip(AXES, xyz, strict=False)), (), (*columns,)), []
    numbers, misfit = body_of(table.array(columns).reshape(len(table.rows), -1, 3))
    count = len(columns) // len(AXES)
    what = "its middle and its turn" if MATRIX[0] in numbers else "its middle"
    remark = (
        f"{table.file}: {count} markers are taken as one rigid body, by {what}; they keep its "
        f"shape to {1e3 * misfit:.2f} mm"
    )
    return NamedColumns(numbers, (), (*columns,)), [remark]


def _placement(
    table: Table,
    named: NamedColumns,
    name: str,
) -> Placement:
    """Return the placement of columns that are named; what is not named is found by names."""
    numbers, names, used = {**named.numbers}, named.joints, named.used
    remarks: list[str] = []
    if numbers.keys().isdisjoint((*AXES, "socket")):
        place, remarks = _place_by_names(table)
        numbers |= place.numbers
        used = (*used, *place.used)
    if "q" not in numbers and table.header:
        joints = table.joints(used)
        numbers["q"] = table.array(joints)
        names = table.names_of(joints) or ()
    axes = numbers.keys() & {*AXES}
    is_whole = "socket" in numbers if not axes else len(axes) == len(AXES)
    if "q" not in numbers or not is_whole:
        raise RecordingError(
            f"{table.file}: --columns: q is needed, and socket, or x, y and z; as in "
            f"{suggestion(table)}"
        )
    placement = _of_numbers(table, numbers, names if table.header else None, name)
    return replace(placement, remarks=(*placement.remarks, *remarks))


def _of_numbers(
    table: Table,
    numbers: dict[str, np.ndarray],
    joint_names: tuple[str, ...] | None,
    name: str,
) -> Placement:
    """Return the placement of numbers by what they are; rows without a place are left out."""
    turn = next((form for form in TURNS if numbers.keys() >= {*AXES, *form}), ())
    measured = (*AXES, *turn) if AXES[0] in numbers else ()
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
            sample = measured_sample(sample, [row[key][0] for key in measured], turn)
        samples.append(sample)
    if not samples:
        raise RecordingError(f"{table.file}: no row has numbers in these columns")
    notes = [*table.notes]
    if lost:
        words = "rows without a place are left out"
        notes.append(f"{table.file}: {len(lost)} {words} (lines {listed(lost)})")
    return Placement(
        name=name,
        samples=tuple(samples),
        joint_names=joint_names,
        files=(table.file,),
        remarks=tuple(notes),
        poses_of="flange" if turn else None,
    )
