"""Names of coordinates: places x, y, z and turns, as programs call them."""

import re
from collections.abc import Sequence
from itertools import product

from .columns import Column
from .joint_columns import COMMANDS, ColumnError, Ways, in_one_way
from .words import Names, Words

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
_SEEN = re.compile(
    "actual|act|measured|meas|m|feedback|ist|gemessen|mesurée?|misurat[ao]|medid[ao]"
)
_ROTVEC = {"rotvec", "r", "rv"}
_HOMOGENEOUS = re.compile(
    r"(?:.*[\W_])?(?:t|h|m|tf|matrix|mat|pose)[\W_]*([0-3])[\W_]*([0-4])\W*",
    re.IGNORECASE,
)
"""Row and column of a homogeneous matrix, counted from 0 where the first is 00."""
_APPROACH = {
    f"{a}{x}": f"r{i}{j}" for j, a in enumerate("noa", 1) for i, x in enumerate(AXES, 1)
}
"""Normal, orientation and approach: the columns of the rotation."""


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
    coordinates = _homogeneous(columns) or [_coordinate(c.words) for c in columns]
    for i, (before, name) in enumerate(coordinates):
        if name not in names or (reserved and reserved in before):
            continue
        places = ways.setdefault((before, ()), {})
        places.setdefault(names.index(name), []).append(i)
        if any(map(COMMANDS.fullmatch, before)):
            sent.add(before)
    ways = {way: places for way, places in ways.items() if way[0] not in sent} or ways
    labels = [f"{column.name} (column {column.index + 1})" for column in columns]
    order = in_one_way(ways, names, labels) or _partly_bare(ways, len(names))
    return [columns[i] for i in order] if order else None


def _partly_bare(ways: Ways, count: int) -> list[int]:
    """Return columns of which some tell what was measured, as in tool X, tool Y, tool Z, qx."""
    bare = ways.get(((), ()), {})
    orders: list[list[int]] = []
    for way, places in ways.items():
        whole = {**bare, **places}
        is_apart = way[0] and not set(bare) & set(places)
        if (
            is_apart
            and len(whole) == count
            and all(len(c) == 1 for c in whole.values())
        ):
            orders.append([whole[k][0] for k in range(count)])
    return orders[0] if len(orders) == 1 else []


def _homogeneous(columns: Sequence[Column]) -> list[tuple[Words, str]]:
    """Return the coordinates of a table with homogeneous matrices; none without one."""
    matches = [_HOMOGENEOUS.fullmatch(column.name) for column in columns]
    places = [m and (int(m[1]), int(m[2])) for m in matches]
    first = 0 if (0, 0) in places else 1
    names: list[tuple[Words, str]] = []
    for place in places:
        i, j = place or (9, 9)
        i, j = i + 1 - first, j + 1 - first
        name = AXES[i - 1] if j == 4 and i < 4 else f"r{i}{j}"
        names.append(((), name if place else ""))
    return names if {*AXES, *MATRIX} <= {name for _, name in names} else []


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
    if last in ("tx", "ty", "tz", "px", "py", "pz"):
        return before, last[1:]
    last = _APPROACH.get(last, last)
    kind = before[-1] if before else ""
    if kind in _TURNED and last in (*AXES, "w"):
        return before[:-1], f"q{last}"
    if kind in _ROTVEC and last in AXES:
        return before[:-1], f"r{last}"
    if kind in _PLACED and last in AXES:
        return before[:-1], last
    return before, last


def place_of(columns: Sequence[Column]) -> list[Column]:
    """Return the columns of a place; none where there are none, or several arms'."""
    try:
        return match_coordinates(columns, AXES) or []
    except ColumnError:
        return []
