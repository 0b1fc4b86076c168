"""Names of coordinates: places x, y, z and turns, as programs call them."""

import math
import re
from collections.abc import Sequence
from itertools import chain, product

import numpy as np

from .columns import Column
from .joint_columns import COMMANDS, ColumnError, Ways, in_one_way
from .recording_error import RecordingError
from .words import COORDINATES, LETTERS, WORDS, Names, Words, any_match

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
_HOMOGENEOUS = re.compile(
    r"(?:.*[\W_])?(?:t|h|m|tf|matrix|mat|pose)[\W_]*([0-3])[\W_]*([0-4])\W*",
    re.IGNORECASE,
)
"""Row and column of a homogeneous matrix, counted from 0 where the first is 00."""


def match_coordinates(
    columns: Sequence[Column],
    names: Names,
    reserved: str = "",
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
    coordinates = _homogeneous(columns) or [_coordinate(c.words) for c in columns]
    for i, (before, name) in enumerate(coordinates):
        if name not in names or (reserved and reserved in before):
            continue
        places = ways.setdefault((before, ()), {})
        places.setdefault(names.index(name), []).append(i)
    measured = [way for way in ways if not any_match(COMMANDS, way[0])]
    ways = {way: ways[way] for way in measured or ways}
    labels = [f"{column.name} (column {column.index + 1})" for column in columns]
    order = in_one_way(ways, names, labels) or _partly_bare(ways, len(names))
    return [columns[i] for i in order] if order else None


def _partly_bare(ways: Ways, count: int) -> list[int]:
    """Return columns of which some tell what was measured, as in tool X, tool Y, tool Z, qx."""
    bare = ways.get(((), ()), {})
    orders: list[list[int]] = []
    for way, places in ways.items():
        whole = {**bare, **places}
        is_apart = way[0] and not bare.keys() & places
        order = list(chain.from_iterable(whole[k] for k in sorted(whole)))
        if is_apart and len(whole) == count == len(order):
            orders.append(order)
    return orders[0] if len(orders) == 1 else []


def _homogeneous(columns: Sequence[Column]) -> list[tuple[Words, str]]:
    """Return the coordinates of a table with homogeneous matrices; none without one."""
    matches = [_HOMOGENEOUS.fullmatch(column.name) for column in columns]
    places = [(int(m[1]), int(m[2])) if m else (9, 9) for m in matches]
    step = int((0, 0) in places)
    names: list[str] = []
    for row, column in places:
        i, j = row + step, column + step
        names.append(AXES[i - 1] if j == 4 and i < 4 else f"r{i}{j}")
    return [((), name) for name in names] if {*AXES, *MATRIX} <= {*names} else []


def _coordinate(words: Words) -> tuple[Words, str]:
    """Return what a coordinate's name begins with, and x, y, z, qx, .. as it is called here."""
    if not words:
        return (), ""
    if COMMANDS.fullmatch(words[-1]) or WORDS["seen"].fullmatch(words[-1]):
        words = (words[-1], *words[:-1])
    joined = "".join(words[-2:])
    if joined in MATRIX:
        return words[:-2], joined
    *_, last = words
    before = words[:-1]
    # Universal Robots number it so.
    if words[-3:-1] == ("tcp", "pose") and last in "012345":
        return before, (*AXES, *VECTOR)[int(last)]
    letter = LETTERS.get(before[-1]) if before else None
    if letter is not None and (last in AXES or letter + last == "qw"):
        return before[:-1], letter + last
    return before, COORDINATES.get(last, last)


def place_of(columns: Sequence[Column]) -> list[Column]:
    """Return the columns of a place; none where there are none, or several arms'."""
    try:
        return match_coordinates(columns, AXES) or []
    except ColumnError:
        return []


_ROUNDED = 0.01
"""Largest deviation from 1 of the length of a quaternion that was written with few digits."""


def unit_quaternion(
    turn: Sequence[float],
    form: Names,
    where: str,
) -> tuple[float, float, float, float]:
    """Return the unit quaternion of a rotation in one of the forms :data:`.TURNS`; refuse others.

    ``where`` begins the message.

    Raises:
        RecordingError: The quaternion's length is not 1, or the matrix is no rotation.
    """
    quaternion = list(turn)
    if tuple(form) in (RPY, FANUC):
        quaternion = _of_rpy(*turn)
    elif tuple(form) == KUKA:
        quaternion = _of_rpy(*turn[::-1])
    elif len(turn) == 3:
        angle = math.hypot(*turn)
        share = math.sin(angle / 2) / angle if angle else 0.5
        quaternion = [*(share * value for value in turn), math.cos(angle / 2)]
    elif len(turn) == 9:
        quaternion = _of_matrix(turn, where)
    length = math.hypot(*quaternion)
    if abs(length - 1) > _ROUNDED:
        raise RecordingError(
            f"{where}: the quaternion {','.join(QUATERNION)} has length {length:.4g} instead of "
            "1; are these its four columns, and not degrees or a rotation vector?"
        )
    qx, qy, qz, qw = [value / length for value in quaternion]
    return qx, qy, qz, qw


def _of_rpy(
    roll: float,
    pitch: float,
    yaw: float,
) -> list[float]:
    """Return the quaternion of turns about x, then y, then z of the fixed frame [rad]."""
    halves = np.array([roll, pitch, yaw]) / 2
    sr, sp, sy = np.sin(halves).tolist()
    cr, cp, cy = np.cos(halves).tolist()
    return [
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    ]


def _of_matrix(rotation: Sequence[float], where: str) -> list[float]:
    """Return the quaternion of a rotation's nine numbers, row by row."""
    a, b, c, d, e, f, g, h, i = rotation
    # four times the outer product of the quaternion with itself; its largest column is the surest
    squares = np.array(
        [
            [1 + a - e - i, b + d, c + g, h - f],
            [b + d, 1 - a + e - i, f + h, c - g],
            [c + g, f + h, 1 - a - e + i, d - b],
            [h - f, c - g, d - b, 1 + a + e + i],
        ]
    )
    largest = squares[squares.diagonal().argmax()]
    quaternion = largest / np.linalg.norm(largest)
    if np.abs(squares - 4 * np.outer(quaternion, quaternion)).max() > 4 * _ROUNDED:
        raise RecordingError(
            f"{where}: r11 to r33 are no rotation; are these its rows?"
        )
    return quaternion.tolist()
