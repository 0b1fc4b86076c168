"""``points.csv`` and ``poses.csv``: joint positions, and what an instrument measured there.

A header of the joints' names in any order, and x, y, z [m], the ball's position in the instrument's
frame; ``points.csv`` may lack it, its joints being in the robot's order. ``poses.csv`` has the
orientation of its link besides: a unit quaternion qx, qy, qz, qw, a rotation vector rx, ry, rz
[rad], or a rotation matrix r11, r12, r13, r21, .. r33 by rows. There may be a
``time`` [s] and a ``temperature``, too.
Other units stand in the header, as ``x [mm]`` or ``JOINT [deg]``.
"""

import math
import re
from dataclasses import replace
from pathlib import Path

from .csv_files import RecordingError, Table, comment_line, read_table
from .placement import Placement
from .samples import Sample

POINTS, POSES = "points.csv", "poses.csv"
_AXES = ("x", "y", "z")
_CLOCKS = ("time", "temperature")
_QUATERNION = ("qx", "qy", "qz", "qw")
_VECTOR = ("rx", "ry", "rz")
_MATRIX = tuple(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
_COLUMN = re.compile(r"(.+?)\s*(?:\[([a-zA-Z]+)\])?")
_MEANINGS = (("flange", "measured flange poses"), ("camera", "camera"), ("commands", "command"))
"""Meaning of poses, and a word of the first line that tells of it."""
_ROUNDED = 0.01
"""Largest deviation from 1 of the length of a quaternion that was written with few digits."""


def read_points(file: Path, name: str) -> Placement:
    """Return the placement of a file that an instrument measured.

    Args:
        file: ``points.csv``, or of any other name one with poses.
        name: Of the placement.

    Raises:
        RecordingError: Missing columns, unknown units, or a quaternion not of unit length; the
            message names file and line.
    """
    table = read_table(file)
    width = len(table.rows[0]) - len(_AXES)
    bare = table.header is None and file.name == POINTS and width > 0
    header = [*map(str, range(width)), *_AXES] if bare else table.header or ()
    columns = [_COLUMN.fullmatch(cell.strip()) for cell in header]
    names = [None if column is None else column[1] for column in columns]
    forms = ((),) if file.name == POINTS else (_QUATERNION, _VECTOR, _MATRIX)
    turns = next((form for form in forms if set(form) <= set(names)), forms[0])
    measured = (*_AXES, *turns)
    clocks = [i for i, name in enumerate(names) if name in _CLOCKS]
    joints = [i for i, name in enumerate(names) if name not in (*measured, *_CLOCKS)]
    count = len(joints) + len(measured) + len(clocks)
    known = len(names) == count and not set(measured) - set(names)
    if None in names or not joints or not known:
        raise RecordingError(
            f"{file}:1: expected a header of the joints' names in chain order, then "
            f"{','.join(measured)}" + ("; or rx,ry,rz; or r11,..,r33" if turns else "")
        )
    scales = [_scale(file, column) for column in columns if column is not None]
    place = [names.index(axis) for axis in measured]
    samples: list[Sample] = []
    for line, row in zip(table.lines, table.rows, strict=True):
        numbers = [a * b for a, b in zip(row, scales, strict=True)]
        where = f"{file}:{line}"
        x, y, z, *turn = (numbers[i] for i in place)
        position = tuple(numbers[i] for i in joints)
        turned = _unit(_quaternion(turn, where), where) if turn else None
        sample = Sample(position, 0, where=where, point=(x, y, z), orientation=turned)
        samples.append(replace(sample, **{str(names[i]): row[i] for i in clocks}))
    comment = comment_line(file).lower()
    return Placement(
        name=name,
        samples=tuple(samples),
        joint_names=None if bare else tuple(str(names[i]) for i in joints),
        files=(file,),
        poses_of=next((meaning for meaning, word in _MEANINGS if word in comment), None),
    )


def joint_columns(table: Table) -> tuple[tuple[str, ...] | None, list[float]]:
    """Return the names of a table's columns without their units, and these in radians or metres."""
    columns = [_COLUMN.fullmatch(cell) for cell in table.header or ()]
    known = [column for column in columns if column is not None]
    names = None if table.header is None else tuple(column[1] for column in known)
    return names, [_scale(table.file, column) for column in known] or [1.0] * len(table.rows[0])


def _scale(file: Path, column: re.Match[str]) -> float:
    """Return the unit of a column in metres or radians; 1 where none is named."""
    name, unit = column[1], column[2] or ""
    if name in _CLOCKS:
        return 1.0
    fit = {"": 1.0} if name in (*_QUATERNION, *_MATRIX) else {"": 1.0, "m": 1.0, "mm": 1e-3}
    if name not in (*_AXES, *_QUATERNION, *_MATRIX):
        fit |= {"rad": 1.0, "deg": math.pi / 180}
    if unit not in fit:
        known = "known are " + ", ".join(f"[{word}]" for word in fit if word)
        known = known if len(fit) > 1 else "it has none"
        raise RecordingError(f"{file}:1: column {name} has unit {unit!r}; {known}")
    return fit[unit]


def _quaternion(turn: list[float], where: str) -> list[float]:
    """Return the quaternion of a rotation vector [rad] or matrix."""
    if len(turn) == 4:
        return turn
    if len(turn) == 3:
        angle = math.hypot(*turn)
        share = math.sin(angle / 2) / angle if angle else 0.5
        return [*(share * value for value in turn), math.cos(angle / 2)]
    a, b, c, d, e, f, g, h, i = turn
    # the outer product of the quaternion with itself, times 4; its largest column is the surest
    columns = [
        [1 + a - e - i, b + d, c + g, h - f],
        [b + d, 1 - a + e - i, f + h, c - g],
        [c + g, f + h, 1 - a - e + i, d - b],
        [h - f, c - g, d - b, 1 + a + e + i],
    ]
    largest = max(range(4), key=lambda k: columns[k][k])
    length = math.hypot(*columns[largest])
    if abs(length**2 / (4 * columns[largest][largest]) - 1) > 2 * _ROUNDED:
        raise RecordingError(f"{where}: r11 to r33 are no rotation; are these its rows?")
    return [value / length for value in columns[largest]]


def _unit(quaternion: list[float], where: str) -> tuple[float, float, float, float]:
    """Return a quaternion of unit length."""
    length = math.hypot(*quaternion)
    if abs(length - 1) > _ROUNDED:
        raise RecordingError(
            f"{where}: the quaternion {','.join(_QUATERNION)} has length {length:.4g} instead of "
            "1; are these its four columns, and not degrees or a rotation vector?"
        )
    qx, qy, qz, qw = (value / length for value in quaternion)
    return qx, qy, qz, qw
