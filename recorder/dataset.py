"""Recordings in a folder: finding placements, and reading ``samples.csv`` or other forms.

A *placement* is one position of the socket base, and the folder with the samples taken there; a
*sample* is one configuration of the arm with the ball in a socket. The folder holds ``samples.csv``
(by ``mukca record``), ``hole_0.csv`` and ``hole_1.csv`` (of the paper's authors), ``points.csv`` or
``poses.csv`` (by an instrument), and beside it ``placement.json``; see docs/files.md.
"""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from .folders import FILES, find_placements, holes_in, unread
from .holes import read_holes
from .metadata import METADATA, read_keys
from .named_columns import with_columns
from .placement import Placement
from .placement_names import distinctly_named, placement_name
from .points import POINTS, POSES
from .recording_error import EmptyRecordingError, RecordingError
from .samples import SAMPLES, read_samples
from .table_placement import read_table_placement


def read_placements(
    *paths: str | Path,
    as_recorded: bool = False,
    columns: Sequence[str] = (),
    on: str = "",
) -> list[Placement]:
    """Read recordings from disk, to calibrate with them or to test a calibration on them.

    ::

        train = mukca.read_placements("recordings/front")
        test = mukca.read_placements("recordings/left", "recordings/right")

    Args:
        paths: One or more folders, each a placement, or a folder of placements, which stands for
            all of them. A table of another program is a placement, too, and so are two that hold
            half the columns each, as ``joints.csv+points.csv``.
        as_recorded: True refuses a placement that cannot be read. By default one beside others is
            left out, and the first placement's remarks say so.
        columns: What the tables' columns are, as ``q=joint_1..6 [deg]`` and ``x=7 [mm]``; none to
            find them by names. Without a table, those of the folders; of sockets the joints alone,
            as ``q=1,-2,3``.
        on: Column by which rows of two tables belong together; empty for their order.

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
    folders = [*find_placements(map(Path, paths))]
    tables = [path for path in folders if not path.is_dir()]
    for folder in folders:
        named = columns if folder in (tables or folders) else ()
        try:
            placements.append(read_placement(folder, named, on))
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


def read_placement(
    folder: Path,
    columns: Sequence[str] = (),
    on: str = "",
) -> Placement:
    """Read the recording in one placement's folder, or in a table of another program.

    Raises:
        RecordingError: A missing, empty or malformed file; the message names file and line.
    """
    if not folder.is_dir():
        return read_table_placement(folder, columns, on)
    holes = holes_in(folder)
    files = [folder / name for name in FILES if (folder / name).exists()]
    files += [file for _, file in holes[:1]]
    if not files:
        raise RecordingError(f"{folder}: no recording in this folder")
    if len(files) > 1:
        raise RecordingError(
            f"{folder}: holds both {files[0].name} and {files[1].name}; keep one of them there"
        )
    file, name = files[0], placement_name(folder)
    if holes:
        placement = read_holes(folder, holes)
    elif file.name == SAMPLES:
        content = read_samples(file)
        if not content.live:
            raise EmptyRecordingError(f"{file}: holds no sample")
        torn = f"{file}: the last line was torn off by a crash and is not read"
        remarks = (torn,) if content.torn.strip() else ()
        placement = Placement(
            name, content.live, content.joint_names, files=(file,), remarks=remarks
        )
    else:
        placement = read_table_placement(file, columns)
        advice = placement.suggestion if columns else None  # else it can be read again
        placement = replace(placement, name=name, suggestion=advice)
    if columns and file.name not in (POINTS, POSES):
        placement = with_columns(placement, columns)
    keys = read_keys(folder / METADATA)
    stated = {key: value for key, value in vars(keys).items() if value is not None}
    stated["remarks"] = (*placement.remarks, *keys.remarks)
    if placement.kind == "points":
        stated.pop("distance", None)
    return replace(placement, **stated)
