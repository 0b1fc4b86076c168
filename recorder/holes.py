"""``hole_0.csv``, ``hole_1.csv``, ..: a file for each socket, a configuration a line."""

from collections.abc import Sequence
from pathlib import Path

from .cells import table_bytes
from .columns import Column
from .foreign_tables import read_table
from .placement import SOCKETS, Placement
from .placement_names import placement_name
from .recording_error import EmptyRecordingError, RecordingError
from .sample import LAST_SOCKET, Sample
from .tables import Table
from .words import UNITS

MOST_SAMPLES = 100_000
"""Number of samples that no file exceeds."""
MOST_OTHERS = 100
"""Number of its other lines, which are header and notes."""


def read_holes(folder: Path, holes: Sequence[tuple[int, Path]]) -> Placement:
    """Return the placement of a folder's files, each with its socket.

    Raises:
        RecordingError: All are empty, or one is no table of the same columns.
    """
    tables: list[tuple[int, Table]] = []
    skipped: list[EmptyRecordingError] = []
    for socket, file in holes:
        if socket > LAST_SOCKET:
            raise RecordingError(
                f"{file}: sockets have numbers from 0 to {LAST_SOCKET}"
            )
        # A log of an arm is refused before its cells are taken apart.
        lines = table_bytes(file).count(b"\n")
        if lines > MOST_SAMPLES + MOST_OTHERS:
            raise RecordingError(
                f"{file}: {lines:,} lines; a line is a sample, and at most {MOST_SAMPLES:,} are "
                "read; of a log of the arm, mukca extract makes samples"
            )
        try:
            tables.append((socket, read_table(file)))
        except EmptyRecordingError as error:
            skipped.append(error)
    if skipped and len(tables) < SOCKETS:
        raise skipped[0]
    joints = _shared_joints([table for _, table in tables])
    first = tables[0][1]
    names = first.names_of(joints)
    beside = first.beside()
    samples: list[Sample] = []
    remarks: list[str] = []
    for socket, table in tables:
        numbers_beside = table.numbers(beside, gaps=True)
        for i, row in enumerate(table.numbers(joints, gaps=names is not None)):
            where = table.where(i)
            samples.append(Sample(row, socket, where=where, beside=numbers_beside[i]))
        remarks += table.notes
    remarks += [f"{error}; the file is skipped" for error in skipped]
    return Placement(
        name=placement_name(folder),
        samples=tuple(samples),
        joint_names=names,
        files=tuple(table.file for _, table in tables),
        remarks=tuple(remarks),
        labels=tuple(first.labels),
        beside=first.names_of(beside) or (),
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
