"""``points.csv`` and ``poses.csv``: joint positions, and what an instrument measured there.

A header of the joints' names in any order, and x, y, z [m], the ball's position in the instrument's
frame; ``poses.csv`` has qx, qy, qz, qw besides, the orientation of its link as a unit quaternion.
Other units stand in the header, as ``x [mm]`` or ``JOINT [deg]``.
"""

import math
import re
from pathlib import Path

from .csv_files import RecordingError, comment_line, read_table
from .placement import Placement
from .samples import Sample

POINTS, POSES = "points.csv", "poses.csv"
_AXES = ("x", "y", "z")
_QUATERNION = ("qx", "qy", "qz", "qw")
_COLUMN = re.compile(r"(.+?)\s*(?:\[([a-zA-Z]+)\])?")
_MEANINGS = (("flange", "measured flange poses"), ("camera", "camera"), ("commands", "command"))
"""Meaning of poses, and a word of the first line that tells of it."""
_ROUNDED = 0.01
"""Largest deviation from 1 of the length of a quaternion that was written with few digits."""


def read_points(file: Path, name: str) -> Placement:
    """Return the placement of a file that an instrument measured.

    Args:
        file: ``points.csv`` or ``poses.csv``.
        name: Of the placement.

    Raises:
        RecordingError: Missing columns, unknown units, or a quaternion not of unit length; the
            message names file and line.
    """
    table = read_table(file)
    columns = [_COLUMN.fullmatch(cell.strip()) for cell in table.header or ()]
    names = [None if column is None else column[1] for column in columns]
    measured = (*_AXES, *(_QUATERNION if file.name == POSES else ()))
    joints = [i for i, name in enumerate(names) if name not in measured]
    known = len(names) == len(joints) + len(measured) and not set(measured) - set(names)
    if None in names or not joints or not known:
        raise RecordingError(
            f"{file}:1: expected a header of the joints' names in chain order, then "
            f"{','.join(measured)}"
        )
    scales = [_scale(file, column) for column in columns if column is not None]
    place = [names.index(axis) for axis in measured]
    samples: list[Sample] = []
    for line, row in zip(table.lines, table.rows, strict=True):
        numbers = [a * b for a, b in zip(row, scales, strict=True)]
        where = f"{file}:{line}"
        x, y, z, *quaternion = (numbers[i] for i in place)
        position = tuple(numbers[i] for i in joints)
        turned = _unit(quaternion, where) if quaternion else None
        samples.append(Sample(position, 0, where=where, point=(x, y, z), orientation=turned))
    comment = comment_line(file).lower()
    return Placement(
        name=name,
        samples=tuple(samples),
        joint_names=tuple(str(names[i]) for i in joints),
        files=(file,),
        poses_of=next((meaning for meaning, word in _MEANINGS if word in comment), None),
    )


def _scale(file: Path, column: re.Match[str]) -> float:
    """Return the unit of a column in metres or radians; 1 where none is named."""
    name, unit = column[1], column[2] or ""
    fit = {"": 1.0} if name in _QUATERNION else {"": 1.0, "m": 1.0, "mm": 1e-3}
    if name not in (*_AXES, *_QUATERNION):
        fit |= {"rad": 1.0, "deg": math.pi / 180}
    if unit not in fit:
        known = "known are " + ", ".join(f"[{word}]" for word in fit if word)
        known = known if len(fit) > 1 else "it has none"
        raise RecordingError(f"{file}:1: column {name} has unit {unit!r}; {known}")
    return fit[unit]


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
