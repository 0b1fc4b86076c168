"""Names of coordinates: places x, y, z and turns, as programs call them."""

import re
from collections.abc import Sequence
from itertools import product

from .columns import Column, Names, Words
from .joint_columns import COMMANDS, Ways, in_one_way

AXES = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
VECTOR = ("rx", "ry", "rz")
RPY = ("roll", "pitch", "yaw")
MATRIX = tuple(f"r{i}{j}" for i, j in product((1, 2, 3), (1, 2, 3)))
KUKA, FANUC = ("a", "b", "c"), ("w", "p", "r")
MAKERS = {*KUKA, *FANUC}
TURNS = (QUATERNION, VECTOR, RPY, MATRIX, KUKA, FANUC)
"""Ways to write a rotation: unit quaternion, rotation vector [rad], R = Rz Ry Rx, rows of R, and
that of two makers: R = Rz(a) Ry(b) Rx(c) = Rz(r) Ry(p) Rx(w)."""
_TURNED = {"orientation", "quaternion", "quat", "q", "rotation", "rot"}
_PLACED = {"position", "translation", "pos", "t", "p"}
_SEEN = re.compile("actual|act|measured|meas|feedback|ist")
_ROTVEC = {"rotvec", "r", "rv"}


def match_coordinates(
    columns: Sequence[Column], names: Names, reserved: str = ""
) -> list[Column] | None:
    """Return the columns called as wanted, with one beginning for all; None where one lacks.

    Args:
        columns: Columns of a table.
        names: Names such as x, y, z, qx.
        reserved: Beginning of names that mean something else.

    Raises:
        ColumnError: Several columns may be one of them.
    """
    ways: Ways = {}
    sent: set[Words] = set()
    for i, column in enumerate(columns):
        before, name = _coordinate(column.words)
        if name not in names or (reserved and reserved in before):
            continue
        places = ways.setdefault((before, ()), {})
        places.setdefault(names.index(name), []).append(i)
        if any(map(COMMANDS.fullmatch, before)):
            sent.add(before)
    ways = {way: places for way, places in ways.items() if way[0] not in sent} or ways
    labels = [f"{column.name} (column {column.index + 1})" for column in columns]
    order = in_one_way(ways, names, labels)
    return [columns[i] for i in order] if order else None


def _coordinate(words: Words) -> tuple[Words, str]:
    """Return what a coordinate's name begins with, and x, y, z, qx, .. as it is called here."""
    if not words:
        return (), ""
    if COMMANDS.fullmatch(words[-1]) or _SEEN.fullmatch(words[-1]):
        words = (words[-1], *words[:-1])
    joined = "".join(words[-2:])
    if joined in MATRIX:
        return words[:-2], joined
    *_, last = words
    before = words[:-1]
    # Universal Robots number it so.
    if words[-3:-1] == ("tcp", "pose") and last in "012345":
        return before, (*AXES, *VECTOR)[int(last)]
    if last in ("tx", "ty", "tz"):
        return before, last[1:]
    kind = before[-1] if before else ""
    if kind in _TURNED and last in (*AXES, "w"):
        return before[:-1], f"q{last}"
    if kind in _ROTVEC and last in AXES:
        return before[:-1], f"r{last}"
    if kind in _PLACED and last in AXES:
        return before[:-1], last
    return before, last
