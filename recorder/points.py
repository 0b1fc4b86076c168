"""``points.csv`` and ``poses.csv``: joint positions, and what an instrument measured there.

A header of the joints' names in any order, and x, y, z [m], the ball's position in the instrument's
frame; ``points.csv`` may lack it, its joints being in the robot's order. ``poses.csv`` has the
orientation of its link besides: a unit quaternion qx, qy, qz, qw, a rotation vector rx, ry, rz
[rad], roll, pitch, yaw [rad], or a rotation matrix r11, r12, r13, r21, .. r33 by rows. There may be
a ``time`` [s] and a ``temperature``, too. Other units stand in the header, as ``x [mm]``.
"""

import math
from collections.abc import Container, Sequence
from dataclasses import replace
from pathlib import Path

from .columns import Column
from .coordinates import (
    AXES,
    MAKERS,
    RPY,
    TURNS,
    VECTOR,
    match_coordinates,
    unit_quaternion,
)
from .joint_columns import ColumnError
from .placement import Placement
from .recording_error import NoColumnsError, RecordingError, UnitError
from .sample import Sample
from .tables import Table
from .words import ANGLES, DEGREES, LENGTHS, UNITS, Names

POINTS, POSES = "points.csv", "poses.csv"
CLOCKS = ("time", "temperature")
FLANGE = "flange"
"""Beginning of the names of columns that hold the flange's pose in place of the joints."""
_MEANINGS = (
    ("flange", "measured flange poses"),
    ("camera", "camera"),
    ("commands", "command"),
)
"""Meaning of poses, and a word of the first line that tells of it."""
HALF_TURN = 180.1
"""Length that no rotation vector exceeds, but for rounding [deg]."""


def placement_of_points(table: Table, name: str) -> Placement:
    """Return the placement of a table that an instrument measured, ``points.csv`` or poses.

    Raises:
        RecordingError: Missing columns, unknown units, or a quaternion not of unit length; the
            message names file and line.
    """
    headless = table.header is None and table.file.name == POINTS
    measured, form = _measured(table, headless)
    joints = table.joints(measured)
    if not joints:
        raise _no_columns(table.file, form)
    clocks = [c for c in table.numeric() if c.name.lower() in CLOCKS]
    beside = table.beside(measured)
    rows = zip(
        table.numbers(joints, gaps=not headless),
        table.numbers(beside, gaps=True),
        table.numbers(clocks),
        table.numbers(measured),
        strict=True,
    )
    samples: list[Sample] = []
    for i, (position, numbers_beside, times, numbers) in enumerate(rows):
        sample = Sample(position, 0, where=table.where(i), beside=numbers_beside)
        clock_times = {c.name.lower(): t for c, t in zip(clocks, times, strict=True)}
        timed = replace(sample, **clock_times)
        samples.append(measured_sample(timed, numbers, form))
    comment = table.comment.lower()
    meanings = [meaning for meaning, word in _MEANINGS if word in comment]
    note = vector_note(table, measured, form)
    return Placement(
        name=name,
        samples=tuple(samples),
        joint_names=table.names_of(joints),
        files=(table.file,),
        remarks=(*table.notes, *filter(None, [note])),
        poses_of=meanings[0] if meanings else None,
        beside=table.names_of(beside) or (),
    )


def measured_sample(
    sample: Sample,
    numbers: Sequence[float],
    form: Names,
) -> Sample:
    """Return a sample with the place and the turn, of some form, that an instrument measured."""
    x, y, z, *turn = numbers
    orientation = unit_quaternion(turn, form, sample.where) if turn else None
    return replace(sample, point=(x, y, z), turn=tuple(turn), orientation=orientation)


def _measured(table: Table, headless: bool) -> tuple[list[Column], tuple[str, ...]]:
    """Return the columns of the place and the turn that were measured, and the turn's form."""
    if headless:
        return table.columns[-3:], ()
    forms = {POINTS: ((),), POSES: TURNS}.get(table.file.name, (*TURNS, ()))
    for form in forms:
        columns = coordinates(table, (*AXES, *form), FLANGE)
        if columns:
            return columns, form
    raise _no_columns(table.file, forms[0])


def _no_columns(file: Path, form: tuple[str, ...]) -> NoColumnsError:
    forms = "; or rx,ry,rz; or roll,pitch,yaw; or r11,..,r33" if form else ""
    return NoColumnsError(
        f"{file}:1: expected a header of the joints' names in chain order, then "
        f"{','.join((*AXES, *form))}{forms}"
    )


def coordinates(
    table: Table,
    names: Names,
    reserved: str = "",
) -> list[Column] | None:
    """Return the columns of coordinates as by :func:`.match_coordinates`, their units checked.

    Raises:
        RecordingError: Several columns may be one of them, or have a unit of something else.
    """
    try:
        columns = match_coordinates(table.columns, names, reserved)
    except ColumnError as error:
        raise RecordingError(f"{table.file}:1: {error}") from None
    for name, column in zip(names, columns or (), strict=False):
        if name in MAKERS and not column.unit:
            raise RecordingError(
                f"{table.file}:1: column {column.name} has no unit: is it {column.name} [deg]?"
            )
        angles = ANGLES if name in (*VECTOR, *RPY, *MAKERS) else ()
        require_unit(table, column, LENGTHS if name in AXES else angles)
    return columns


def require_unit(
    table: Table,
    column: Column,
    units: Container[str],
) -> None:
    """Refuse a column in a unit that is not among some.

    Raises:
        UnitError: Its numbers would be taken for what they are not.
    """
    if column.unit and column.unit not in units:
        some = ", ".join(f"[{unit}]" for unit in UNITS if unit in units)
        choices = f"known are {some}" if some else "it has none"
        raise UnitError(
            f"{table.file}:1: column {column.name} has unit {column.unit!r}; {choices}"
        )


def vector_note(
    table: Table,
    columns: Sequence[Column],
    form: Names,
) -> str:
    """Return how a rotation vector among columns is taken, in words; empty without one."""
    if not {*VECTOR} <= {*form}:
        return ""
    unit = "degrees" if columns[-1].unit in DEGREES else "radians"
    words = f"rx,ry,rz are taken as a rotation vector in {unit}"
    return f"{table.file}: {words}, as a UR's pendant has it"


def require_vectors(rows: Sequence[Sequence[float]], wheres: Names) -> None:
    """Refuse rows that end in a rotation vector longer than half a turn.

    Raises:
        RecordingError: Euler angles, most likely; the message names file and line.
    """
    for row, where in zip(rows, wheres, strict=True):
        length = math.degrees(math.hypot(*row[-3:]))
        if length > HALF_TURN:
            raise RecordingError(
                f"{where}: rx,ry,rz are {length:.1f} degrees long, and no rotation vector is "
                "longer than half a turn; are they Euler angles? name them roll,pitch,yaw "
                "(R = Rz Ry Rx)"
            )
