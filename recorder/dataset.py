"""Recordings in a folder: finding placements, and reading ``samples.csv`` or other forms.

A *placement* is one position of the socket base, and the folder with the samples taken there; a
*sample* is one configuration of the arm with the ball in a socket. The folder holds ``samples.csv``
(by ``mukca record``), ``hole_0.csv`` and ``hole_1.csv`` (of the paper's authors), ``points.csv`` or
``poses.csv`` (by an instrument), and beside it ``placement.json``; see docs/recording.md.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from .cells import table_bytes
from .columns import UNITS, Column
from .folders import FILES, find_placements, holes_in, unread
from .metadata import METADATA, read_keys
from .placement import SOCKETS, Placement
from .placement_names import distinctly_named, placement_name
from .points import read_points
from .recording_error import EmptyRecordingError, RecordingError
from .samples import LAST_SOCKET, SAMPLES, Sample, read_samples
from .tables import Table, read_table

MOST_SAMPLES = 100_000
"""Number of samples that no file exceeds."""
MOST_OTHERS = 100
"""Number of its other lines, which are header and notes."""


def read_placements(*paths: str | Path, as_recorded: bool = False) -> list[Placement]:
    """Read recordings from disk, to calibrate with them or to test a calibration on them.

    ::

        train = mukca.read_placements("recordings/front")
        test = mukca.read_placements("recordings/left", "recordings/right")

    Args:
        paths: One or more folders, each a placement, or a folder of placements, which stands for
            all of them.
        as_recorded: True refuses a placement that cannot be read. By default one beside others is
            left out, and the first placement's remarks say so.

    Returns:
        The placements, in the order of the paths; those inside one folder by name.

    Raises:
        RecordingError: No path is given, a folder holds no recording, or all that can be read is
            empty or malformed; the message names file and line.
    """
    if not paths:
        raise RecordingError(
            "no placement is given; name at least one folder of recordings"
        )
    for path in cast("tuple[object, ...]", paths):
        if not isinstance(path, str | os.PathLike):
            raise RecordingError(f"{path!r:.60}: no path; name the folders one by one")
    placements: list[Placement] = []
    skipped: list[RecordingError] = []
    for folder in find_placements(map(Path, paths)):
        try:
            placements.append(read_placement(folder))
        except RecordingError as error:
            if as_recorded:
                raise
            skipped.append(error)
    if not placements:
        raise skipped[0]
    remarks = [f"{error}; the placement is left out" for error in skipped]
    remarks += unread(map(Path, paths))
    first, *others = distinctly_named(placements)
    return [replace(first, remarks=(*first.remarks, *remarks)), *others]


def read_placement(folder: Path) -> Placement:
    """Read the recording in one placement's folder.

    Raises:
        RecordingError: A missing, empty or malformed file; the message names file and line.
    """
    holes = holes_in(folder)
    files = [folder / name for name in FILES if (folder / name).exists()]
    files += [file for _, file in holes[:1]]
    if not files:
        raise RecordingError(f"{folder}: no recording in this folder")
    if len(files) > 1:
        raise RecordingError(
            f"{folder}: holds both {files[0].name} and {files[1].name}; keep one of them there"
        )
    if holes:
        placement = _read_holes(folder, holes)
    elif files[0].name == SAMPLES:
        placement = _read_recorded(files[0])
    else:
        placement = read_points(files[0], placement_name(folder))
    keys = vars(read_keys(folder / METADATA))
    stated = {key: value for key, value in keys.items() if value is not None}
    if placement.kind == "points":
        stated.pop("distance", None)
    return replace(placement, **stated)


def _read_recorded(file: Path) -> Placement:
    content = read_samples(file)
    if not content.live:
        raise EmptyRecordingError(f"{file}: holds no sample")
    torn = f"{file}: the last line was torn off by a crash and is not read"
    return Placement(
        name=placement_name(file.parent),
        samples=content.live,
        joint_names=content.joint_names,
        files=(file,),
        remarks=(torn,) if content.torn.strip() else (),
    )


def _read_holes(folder: Path, holes: list[tuple[int, Path]]) -> Placement:
    tables: list[tuple[int, Table]] = []
    skipped: list[EmptyRecordingError] = []
    for socket, file in holes:
        if socket > LAST_SOCKET:
            raise RecordingError(
                f"{file}: sockets have numbers from 0 to {LAST_SOCKET}"
            )
        _require_samples(file)
        try:
            tables.append((socket, read_table(file)))
        except EmptyRecordingError as error:
            skipped.append(error)
    if skipped and len(tables) < SOCKETS:
        raise skipped[0]
    joints = _shared_joints([table for _, table in tables])
    has_header = tables[0][1].header is not None
    beside = tables[0][1].beside()
    samples: list[Sample] = []
    remarks: list[str] = []
    for socket, table in tables:
        numbers_beside = table.numbers(beside, gaps=True)
        for i, row in enumerate(table.numbers(joints, gaps=has_header)):
            where = table.where(i)
            samples.append(Sample(row, socket, where=where, beside=numbers_beside[i]))
        remarks += table.notes
    remarks += [f"{error}; the file is skipped" for error in skipped]
    names = tuple(column.name for column in joints)
    return Placement(
        name=placement_name(folder),
        samples=tuple(samples),
        joint_names=names if has_header else None,
        files=tuple(table.file for _, table in tables),
        remarks=tuple(remarks),
        labels=tables[0][1].labels,
        beside=tuple(column.name for column in beside),
    )


def _shared_joints(tables: Sequence[Table]) -> list[Column]:
    """Return the columns of joint positions, which are the same in all tables.

    Raises:
        RecordingError: The first table has none, or another one has other columns.
    """
    first, *others = tables
    joints = first.joints()
    if first.header and not joints:
        raise RecordingError(
            f"{first.file}:1: no column holds joint positions in {', '.join(UNITS)}; the header "
            f"is {','.join(first.header):.150}"
        )
    if not joints:
        raise RecordingError(
            f"{first.where(0)}: no column holds numbers; write 0.1 and separate by commas"
        )
    width = len(first.rows[0])
    for table in others:
        if table.header != first.header or table.units != first.units:
            raise RecordingError(
                f"{table.file}:1: another header than in {first.file.name}"
            )
        if len(table.rows[0]) != width:
            raise RecordingError(
                f"{table.where(0)}: {len(table.rows[0])} columns, "
                f"but {first.file.name} has {width}"
            )
    return joints


def _require_samples(file: Path) -> None:
    """Refuse a log of an arm in the place of samples, before its cells are taken apart."""
    lines = table_bytes(file).count(b"\n")
    if lines > MOST_SAMPLES + MOST_OTHERS:
        raise RecordingError(
            f"{file}: {lines:,} lines; a line is a sample, and at most {MOST_SAMPLES:,} are read; "
            "of a log of the arm, mukca extract makes samples"
        )
