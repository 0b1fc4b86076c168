"""A log of any kind, read by its kind; kept streams and CSV files are read here."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...recorder import (
    DEGREES,
    Column,
    ColumnError,
    Table,
    filled_rows,
    find_joints,
    read_stream_log,
    read_table,
    require_units,
    scale_of,
    seconds_of,
)
from ...solver.calibration import joints_named
from .bags import read_bag, read_lerobot_log
from .log import (
    ExtractError,
    Log,
    Question,
    check_angles,
    in_parts,
    needed_columns,
    refuse_normalised,
    require_angles,
    require_rate,
    unknown_joints,
    which_arm,
)


def read_log(question: Question) -> Log:
    """Return the joint states of a log of any kind.

    Raises:
        ExtractError: There is nothing there, or nothing that can be read; see also the modules.
        RecordingError: A file is damaged.
    """
    read = _reader(question.path)
    if question.topic is not None and read is not read_bag:
        raise ExtractError("--topic is for bags")
    if question.units is not None and read is read_kept_stream:
        raise ExtractError("--units is for lerobot data sets, CSV logs and bags")
    log = read(question)
    if not len(log.stamps):
        raise ExtractError(f"{question.path}: no state in it can be used")
    return log


def _reader(path: Path) -> Callable[[Question], Log]:
    """Return what reads a log of a path's kind."""
    if not path.exists():
        raise ExtractError(f"{path}: no such file or folder")
    if path.is_dir() and (path / "meta" / "info.json").exists():
        return read_lerobot_log
    if path.suffix in (".csv", ".tsv", ".txt"):
        return read_csv_log
    streams = path.glob("*.stream") if path.is_dir() else ()
    if path.suffix == ".stream" or any(streams):
        return read_kept_stream
    if path.suffix in (".bag", ".db3", ".mcap") or (path / "metadata.yaml").exists():
        return read_bag
    raise ExtractError(
        f"{path}: nothing that can be read. Give a ROS bag (.bag, .db3, .mcap, or a folder with "
        "metadata.yaml), a lerobot data set, a CSV log, or a recording with a kept stream"
    )


def read_kept_stream(question: Question) -> Log:
    """Return the states of a kept stream, or of all in a placement's folder, one part each."""
    path = question.path
    files = [path]
    if path.is_dir():
        files = sorted(path.glob("*.stream"), key=lambda f: (len(f.name), f.name))
    nothing = np.empty((0, len(question.joints)))
    rows = [(np.empty(0), nothing, nothing, np.empty(0, dtype=int))]
    notes = list[str]()
    last = 0
    measured = True
    for file in files:
        stream = read_stream_log(file)
        columns = needed_columns(stream.joints, question)
        if not len(stream.stamps):
            continue
        notes += [f"read {file.name}, {len(stream.stamps)} states", *stream.remarks]
        efforts = stream.efforts
        if efforts is None:
            measured = False
            efforts = np.zeros_like(stream.positions)
        parts = stream.connections - stream.connections.min() + last
        last = int(parts.max()) + 1
        q, torques = stream.positions[:, columns], efforts[:, columns]
        rows.append((stream.stamps, q, torques, parts))
    fields = zip(*rows, strict=True)
    stamps, positions, torques, numbers = map(np.concatenate, fields)
    return Log(stamps, positions, torques if measured else None, numbers, tuple(notes))


_TIME = re.compile(
    r"_*%?(?:.*header[./_]stamp[./_])?(?:secs?|seconds|"
    r"(?:time|stamp|timestamp|t|time_?stamp|date_?time)(?:_(secs?|[mun]?s))?)",
    re.I,
)
"""Names of columns of time, perhaps with their unit."""
_FRACTION = re.compile(
    r"(?:(?:.*[\W_])?(?:time|stamp|t)[\W_])?((?:milli|micro|nano|[mun])s)(?:ecs?|econds?)?",
    re.I,
)
"""Names of the column that holds what a column of whole seconds lacks."""
_UNITS = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9}
_SECONDS = _UNITS | {"millis": 1e-3, "micros": 1e-6, "nanos": 1e-9}
"""Parts of a second by the beginnings of their names."""
_SINCE_1970 = {1e17: 1e-9, 1e14: 1e-6, 1e11: 1e-3}
"""Times larger than this are counted from 1970 in nanoseconds, and so on."""


def read_csv_log(question: Question) -> Log:
    """Return the joint states of a CSV file with a column of time and one for each joint."""
    table = read_table(question.path, question.joints)
    if table.header is None:
        raise ExtractError(f"{question.path}:1: name the columns: time, and the joints")
    joints = set(question.joints)
    called = [column for column in table.columns if column.name not in joints]
    times = [column for column in called if _TIME.fullmatch(column.name)]
    if not times:
        raise ExtractError(
            f"{question.path}:1: no column of time; call it time, or time[ms] and so on; "
            f"columns: {', '.join(table.header)}"
        )
    columns, notes = _joint_columns(table, times[:1], question)
    filled = filled_rows(table, columns)
    count = len(filled.rows)
    if empty := len(table.rows) - count:
        notes.append(f"{empty} lines without positions are left out")
    positions = _in_radians(np.array(filled.numbers(columns)), columns, question)
    log = in_parts(_stamps(filled, times[0]), positions, None, notes)
    advice = "if time is not in seconds, name its column time[ms], [us] or [ns]"
    if len(log.stamps) <= count / 2:
        advice = "many rows have one time: write its fractions, or nanosec in a column beside"
    require_rate(log, question, advice)
    return log


def _joint_columns(
    table: Table, times: Sequence[Column], question: Question
) -> tuple[list[Column], list[str]]:
    """Return the columns of the joints, and remarks."""
    names = [column.name for column in table.columns]
    if question.named is not None:
        joints = joints_named(question.named, question.joints)
        for words in (table.header or (), names):
            if set(joints) <= set(words):
                columns = [table.columns[words.index(joint)] for joint in joints]
                require_units(table, columns)
                return columns, [*table.notes]
    else:
        try:
            match = find_joints(table, question.joints, times)
        except ColumnError as error:
            raise ExtractError(which_arm(error, question)) from None
        if match:
            return match[0], [*table.notes, *filter(None, match[1:])]
    others = [column.name for column in table.columns if column not in times]
    raise unknown_joints(others, question)


def _stamps(table: Table, column: Column) -> np.ndarray:
    """Return the times of a log's rows [s], from numbers or from dates."""
    cells = [row[column.index] for row in table.rows]
    dates = [seconds_of(cell) for cell in cells]
    if dates and None not in dates:
        return np.array(dates, dtype=float)
    stamps = _plain_numbers(table, column)
    match = _TIME.fullmatch(column.name)
    unit = (column.unit or (match and match[1]) or "").lower()
    if unit in _SECONDS:
        return stamps * _SECONDS[unit]
    if not (stamps % 1).any():
        stamps = stamps + _fractions(table)
    if unit:
        return stamps
    largest = float(np.abs(stamps).max(initial=0.0))
    units = (unit for limit, unit in _SINCE_1970.items() if largest > limit)
    return stamps * next(units, 1.0)


def _fractions(table: Table) -> np.ndarray | float:
    """Return the column that is parts of a second by its name and numbers [s]; 0 without one."""
    for column in table.columns:
        match = _FRACTION.fullmatch(column.name)
        if match and not table.is_text(column.index):
            seconds = _plain_numbers(table, column) * _SECONDS[match[1].lower()]
            if seconds.min() >= 0 and seconds.max() < 1:
                return seconds
    return 0.0


def _plain_numbers(table: Table, column: Column) -> np.ndarray:
    """Return a column's numbers as they stand there, in whatever unit."""
    return np.array(table.numbers([replace(column, unit="")]))[:, 0]


def _in_radians(
    positions: np.ndarray, columns: Sequence[Column], question: Question
) -> np.ndarray:
    """Return angles in radians; degrees where the header says so, or the user does instead."""
    require_angles(question, "a CSV log")
    turning = question.turning
    in_degrees = np.array([column.unit in DEGREES for column in columns])
    degrees = bool((in_degrees & turning).any())
    if question.units is not None:
        degrees = question.units == "degrees"
        unit = np.radians(1.0) if degrees else 1.0
        scales = unit / np.array([scale_of(column) for column in columns])
        positions = positions * np.where(turning, scales, 1.0)
    if degrees:
        refuse_normalised(np.rad2deg(positions[:, turning]), question)
    check_angles(positions, degrees, question)
    return positions
