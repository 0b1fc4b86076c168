"""Names of coordinates: places x, y, z and turns, as programs call them."""

from collections.abc import Sequence
from itertools import chain, product

from .columns import Column, ColumnError, Words

AXES = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
VECTOR = ("rx", "ry", "rz")
RPY = ("roll", "pitch", "yaw")
MATRIX = tuple(f"r{i}{j}" for i, j in product((1, 2, 3), (1, 2, 3)))
TURNS = (QUATERNION, VECTOR, RPY, MATRIX)
"""Ways to write a rotation: unit quaternion, rotation vector [rad], R = Rz Ry Rx, and rows of R."""
_TURNED = {"orientation", "quaternion", "quat", "q", "rotation", "rot"}
_PLACED = {"position", "translation", "pos", "t", "p"}
_ROTVEC = {"rotvec", "r", "rv"}


def match_coordinates(
    columns: Sequence[Column], names: Sequence[str], reserved: str = ""
) -> list[Column] | None:
    """Return the columns called as wanted, with one beginning for all; None where one lacks.

    Args:
        columns: Columns of a table.
        names: Names such as x, y, z, qx.
        reserved: Beginning of names that mean something else.

    Raises:
        ColumnError: Several columns may be one of them.
    """
    ways: dict[Words, dict[str, list[Column]]] = {}
    for column in columns:
        before, name = _coordinate(column.words)
        if name in names and (not reserved or reserved not in before):
            ways.setdefault(before, {}).setdefault(name, []).append(column)
    complete = [way for way in ways if len(ways[way]) == len(names)]
    prefixes = [()] if () in complete else complete
    if not prefixes:
        return None
    fitting = list(chain.from_iterable(ways[way][names[0]] for way in prefixes))
    twice = next((c for c in ways[prefixes[0]].values() if len(c) > 1), None)
    if len(fitting) > 1 or twice:
        some = [f"{column.name} (column {column.index + 1})" for column in twice or fitting]
        raise ColumnError(twice[0].name if twice else names[0], some)
    return [ways[prefixes[0]][name][0] for name in names]


def _coordinate(words: Words) -> tuple[Words, str]:
    """Return what a coordinate's name begins with, and x, y, z, qx, .. as it is called here."""
    joined = "".join(words[-2:]) if words[-1:] and words[-1].isdecimal() else ""
    if joined in MATRIX:
        return words[:-2], joined
    if words[-3:-1] == ("tcp", "pose") and words[-1] in "012345":  # as Universal Robots number it
        return words[:-1], (*AXES, *VECTOR)[int(words[-1])]
    before, last = words[:-1], (words or ("",))[-1]
    if last in ("tx", "ty", "tz"):
        return before, last[1:]
    if last in (*AXES, "w") and before and before[-1] in _TURNED:
        return before[:-1], f"q{last}"
    if last in AXES and before and before[-1] in _ROTVEC:
        return before[:-1], f"r{last}"
    if last in AXES and before and before[-1] in _PLACED:
        return before[:-1], last
    return before, last
