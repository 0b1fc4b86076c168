"""Solids as data: primitives, set operations and letters to engrave, and the limits of all parts.

A part is described once, and evaluated by two :mod:`.kernels`. Lengths are millimetres; z is up.
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...errors import MukcaError, read_beside

TILT = math.radians(60)
"""Largest lean of the ball's neck from the vertical, in every direction [rad]."""

BED = 180.0
"""A part fits into a cube of this edge [mm]."""
Point = tuple[float, float]
Outline = tuple[Point, ...]
"""A closed polygon in the plane, anticlockwise; a hole in another one is clockwise."""


class PrintableError(MukcaError):
    """A part cannot be made as asked for."""


def check_range(
    name: str,
    value: float,
    low: float,
    high: float,
) -> None:
    """Refuse a length out of its range [mm]."""
    if not low <= value <= high:
        raise PrintableError(f"{name} of {value:g} mm: expected {low:g} to {high:g} mm")


@dataclass(frozen=True)
class Solid:
    """A set of points of space, as numbers or as a combination; ``|``, ``-``, ``&`` combine two."""

    kind: str
    """``sphere``, ``frustum``, ``prism``, ``moved`` or ``leaned``, or how parts combine: ``Add``,
    ``Subtract`` all others from the first, ``Intersect``."""
    numbers: tuple[Any, ...] = ()
    parts: tuple["Solid", ...] = ()

    def __or__(self, solid: "Solid") -> "Solid":
        return union(self, solid)

    def __sub__(self, solid: "Solid") -> "Solid":
        removed = solid.parts if solid.kind == "Add" else (solid,)
        return Solid("Subtract", (), (self, *removed))

    def __and__(self, solid: "Solid") -> "Solid":
        return Solid("Intersect", (), (self, solid))

    def at(
        self,
        x: float = 0.0,
        y: float = 0.0,
        z: float = 0.0,
    ) -> "Solid":
        """Return the solid moved by an offset."""
        return Solid("moved", (x, y, z), (self,))

    def at_each(self, places: Iterable[Point], z: float = 0.0) -> list["Solid"]:
        """Return the solid moved by each of some offsets."""
        return [self.at(x, y, z) for x, y in places]

    def leaned(self, lean: float, azimuth: float) -> "Solid":
        """Return the solid turned about y, so that z leans towards x, and then about z [rad]."""
        return Solid("leaned", (lean, azimuth), (self,))


def sphere(radius: float) -> Solid:
    """Return a ball about the origin."""
    return Solid("sphere", (radius,))


def frustum(height: float, low: float, high: float) -> Solid:
    """Return a truncated cone about the z axis, from z = 0 up, by its radii below and above."""
    return Solid("frustum", (height, low, high))


def cylinder(radius: float, height: float) -> Solid:
    """Return a cylinder about the z axis, from z = 0 up."""
    return frustum(height, radius, radius)


def prism(height: float, *outlines: Outline) -> Solid:
    """Return outlines in the plane z = 0, extruded upwards."""
    return Solid("prism", (height, *outlines))


def union(*parts: Solid) -> Solid:
    """Return all points of any of the parts."""
    return Solid("Add", (), parts)


def rectangle(x: Point, y: Point, corner: float = 0.0) -> Outline:
    """Return the rectangle between two values of x and of y, its corners cut off at 45 degrees."""
    x0, x1 = x
    y0, y1 = y
    if corner == 0.0:
        return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    return (
        (x0 + corner, y0),
        (x1 - corner, y0),
        (x1, y0 + corner),
        (x1, y1 - corner),
        (x1 - corner, y1),
        (x0 + corner, y1),
        (x0, y1 - corner),
        (x0, y0 + corner),
    )


def hexagon(apothem: float) -> Outline:
    """Return the regular hexagon whose flats face 0, 60, 120, ... degrees at that distance."""
    radius = apothem / math.cos(math.pi / 6)
    angles = map(math.radians, range(30, 390, 60))
    return tuple((radius * math.cos(a), radius * math.sin(a)) for a in angles)


def signed_area(points: Sequence[Point]) -> float:
    """Return the area of a polygon by the shoelace formula, negative if it runs clockwise."""
    sides = zip(points, (*points[1:], *points[:1]), strict=True)
    return math.fsum(x * v - u * y for (x, y), (u, v) in sides) / 2


HEIGHT = 5.4
"""Height of a letter at scale 1, strokes included [mm]."""
STROKE = 0.9
DEPTH = 0.8

TABLES = read_beside(__file__, "tables.json")
"""Screws, mounts, and letters: the width between the middles of the outermost strokes [mm], and
corners of polylines on a grid of 2 by 4, digits being those of a seven-segment display."""
_LETTERS: Mapping[str, tuple[float, Sequence[str]]] = TABLES["letters"]
_RISE = 4.5  # of a letter, between the middles of its outermost strokes
_GAP = 1.2  # between the strokes of neighbouring letters


def text_width(text: str, scale: float = 1.0) -> float:
    """Return the width of a line of text, strokes included [mm]."""
    pitches = [_LETTERS[letter][0] + STROKE + _GAP for letter in text]
    return scale * (sum(pitches) - _GAP)


def engraving(
    text: str,
    x: float,
    y: float,
    top: float,
    scale: float = 1.0,
) -> Solid:
    """Return the tool that engraves a line of text about x, y into a flat top [mm]."""
    width = text_width(text, scale) - scale * STROKE
    rise = scale * _RISE
    tool = prism(DEPTH + 1.0, *_outlines(text, scale))
    return tool.at(x - width / 2, y - rise / 2, top - DEPTH)


def _outlines(text: str, scale: float) -> Iterator[Outline]:
    from manifold3d import CrossSection, OpType

    square = CrossSection.square((STROKE, STROKE), True)
    bars: list[CrossSection] = []
    begin = 0.0
    for letter in text:
        width, strokes = _LETTERS[letter]
        for stroke in strokes:
            corners: list[CrossSection] = []
            for column, row in stroke.split():
                x = begin + int(column) / 2 * width
                y = int(row) / 4 * _RISE
                corners.append(square.translate((x, y)))
            for pair in itertools.pairwise(corners):
                bars.append(CrossSection.batch_hull([*pair]))
        begin += width + STROKE + _GAP
    union_of_bars = CrossSection.batch_boolean(bars, OpType.Add)
    shape: Any = union_of_bars.scale((scale, scale))
    for ring in shape.to_polygons():
        yield tuple((float(x), float(y)) for x, y in ring)
