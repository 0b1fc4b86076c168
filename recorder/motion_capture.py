"""Names of columns in what motion capture exports: TSV of Qualisys, CSV of OptiTrack and Vicon.

Qualisys names markers above the numbers. Of a rigid body it has R = Rx(roll) Ry(pitch) Rz(yaw), and
R itself by columns, Rot[0] to Rot[8], which is read.
"""

import re
from collections.abc import Sequence
from itertools import product

from .columns import Line

_ROTATION = re.compile(r"(.*?)rot\[(\d)\]", re.IGNORECASE)
_ANGLE = re.compile(r".*\b(roll|pitch|yaw)", re.IGNORECASE)
_PLACE = re.compile(r"(.*\W)?[xyz]", re.IGNORECASE)


def capture_names(titles: Sequence[Line], width: int) -> list[Line]:
    """Return the names of markers' coordinates as one line; none where no title names them."""
    for line, cells in titles:
        markers = list(filter(None, cells[1:]))
        names = [f"{name} {axis}" for name, axis in product(markers, "XYZ")]
        beside = width - len(names)
        if cells[0] == "MARKER_NAMES" and beside in (0, 2):
            names = ["Frame", "Time"][:beside] + names
            return [(line, named_capture(names, titles))]
    return []


def named_capture(names: Sequence[str], titles: Sequence[Line]) -> list[str]:
    """Return names with the unit of places that titles above them tell, and a body's rotation."""
    facts: dict[str, str] = {}
    for _, cells in titles:
        facts |= dict(zip(cells, [*cells[1:], ""], strict=True))
    unit = "mm" if "NO_OF_CAMERAS" in facts else facts.get("Length Units", "")
    rotations = [_ROTATION.fullmatch(name) for name in names]
    if "BODY_NAMES" not in facts:
        rotations = [None] * len(names)
    named: list[str] = []
    for name, match in zip(names, rotations, strict=True):
        if match:
            column, row = divmod(int(match[2]), 3)
            name = f"{match[1]}r{row + 1}{column + 1}"
        elif any(rotations) and _ANGLE.fullmatch(name):
            name = f"{name} angle"
        elif unit and _PLACE.fullmatch(name) and "rotation" not in name.lower():
            name = f"{name} [{unit}]"
        named.append(name)
    return named
