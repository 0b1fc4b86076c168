"""Solids as data: primitives, set operations and letters to engrave, and the limits of all parts.

A part is described once, and evaluated by two :mod:`.kernels`. Lengths are millimetres; z is up.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ...errors import MukcaError

if TYPE_CHECKING:
    from manifold3d import CrossSection

TILT = math.radians(60)
"""Largest lean of the ball's neck from the vertical, in every direction [rad]."""

BED = 180.0
"""A part fits into a cube of this edge [mm]."""
Outline = tuple[tuple[float, float], ...]
"""A closed polygon in the plane, anticlockwise; a hole in another one is clockwise."""


class PrintableError(MukcaError):
    """A part cannot be made as asked for."""


def check_range(name: str, value: float, low: float, high: float) -> None:
    """Refuse a length out of its range [mm]."""
    if not low <= value <= high:
        raise PrintableError(f"{name} of {value:g} mm: expected {low:g} to {high:g} mm")


@dataclass(frozen=True)
class Solid:
    """A set of points of space; ``|``, ``-`` and ``&`` combine two."""

    def __or__(self, other: "Solid") -> "Solid":
        return Union((self, other))

    def __sub__(self, other: "Solid") -> "Solid":
        return Difference(self, other)

    def __and__(self, other: "Solid") -> "Solid":
        return Intersection(self, other)

    def at(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> "Solid":
        """Return the solid moved by an offset."""
        return Moved(self, (x, y, z))


@dataclass(frozen=True)
class Sphere(Solid):
    """A ball about the origin."""

    radius: float


@dataclass(frozen=True)
class Frustum(Solid):
    """A truncated cone about the z axis, from z = 0 up; a cylinder where both radii agree."""

    height: float
    low: float
    high: float


@dataclass(frozen=True)
class Prism(Solid):
    """Outlines in the plane z = 0, extruded upwards."""

    outlines: tuple[Outline, ...]
    height: float


@dataclass(frozen=True)
class Union(Solid):
    """All points of any of the parts."""

    parts: tuple[Solid, ...]


@dataclass(frozen=True)
class Difference(Solid):
    """The points of one solid that are not in the other."""

    body: Solid
    tool: Solid


@dataclass(frozen=True)
class Intersection(Solid):
    """The points that two solids share."""

    left: Solid
    right: Solid


@dataclass(frozen=True)
class Moved(Solid):
    """A solid moved by an offset."""

    solid: Solid
    offset: tuple[float, float, float]


def union(*parts: Solid) -> Solid:
    """Return all points of any of the parts."""
    return Union(parts)


def cylinder(radius: float, height: float) -> Solid:
    """Return a cylinder about the z axis, from z = 0 up."""
    return Frustum(height, radius, radius)


def rectangle(x: tuple[float, float], y: tuple[float, float], corner: float = 0.0) -> Outline:
    """Return the rectangle between two values of x and of y, its corners cut off at 45 degrees."""
    (x0, x1), (y0, y1), c = x, y, corner
    if c == 0.0:
        return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    return (
        *((x0 + c, y0), (x1 - c, y0), (x1, y0 + c), (x1, y1 - c)),
        *((x1 - c, y1), (x0 + c, y1), (x0, y1 - c), (x0, y0 + c)),
    )


def hexagon(apothem: float) -> Outline:
    """Return the regular hexagon whose flats face 0, 60, 120, ... degrees at that distance."""
    radius = apothem / math.cos(math.pi / 6)
    angles = [math.radians(30 + 60 * i) for i in range(6)]
    return tuple((radius * math.cos(a), radius * math.sin(a)) for a in angles)


def signed_area(points: Sequence[tuple[float, float]]) -> float:
    """Return the area of a polygon by the shoelace formula, negative if it runs clockwise."""
    pairs = zip(points, (*points[1:], *points[:1]), strict=True)
    return math.fsum(a[0] * b[1] - b[0] * a[1] for a, b in pairs) / 2


HEIGHT = 5.4
"""Height of a letter at scale 1, strokes included [mm]."""
STROKE = 0.9
DEPTH = 0.8

_WIDTH, _RISE = 2.4, 4.5  # of a letter, between the middles of its outermost strokes
_GAP = 1.2  # between the strokes of neighbouring letters

# Corners of polylines, on a grid of 2 by 4; digits are those of a seven-segment display.
_STROKES: dict[str, tuple[str, ...]] = {
    "0": ("00 20 24 04 00",),
    "1": ("10 14 03",),
    "2": ("04 24 22 02 00 20",),
    "3": ("04 24 20 00", "02 22"),
    "4": ("04 02 22", "24 20"),
    "5": ("24 04 02 22 20 00",),
    "6": ("24 04 00 20 22 02",),
    "7": ("04 24 20",),
    "8": ("00 20 24 04 00", "02 22"),
    "9": ("22 02 04 24 20 00",),
    ".": ("00 00",),
    "I": ("00 04",),
    "n": ("00 02 22 20",),
    "O": ("00 20 24 04 00",),
    "T": ("10 14", "04 24"),
    "U": ("04 00 20 24",),
    "Z": ("04 24", "24 00", "00 20"),
    " ": (),
}
_NARROW = {".": 0.0, "I": 0.0, " ": 0.4, "1": 1.2}  # widths that differ from _WIDTH


def text_width(text: str, scale: float = 1.0) -> float:
    """Return the width of a line of text, strokes included [mm]."""
    return scale * (sum(_advance(letter) for letter in text) - _GAP)


def engraving(text: str, x: float, y: float, top: float, scale: float = 1.0) -> Solid:
    """Return the tool that engraves a line of text about x, y into a flat top [mm]."""
    outlines = _outlines(text, scale)
    middle_x = x - (text_width(text, scale) - scale * STROKE) / 2
    tool = Prism(outlines, DEPTH + 1.0)
    return tool.at(middle_x, y - scale * _RISE / 2, top - DEPTH)


def _outlines(text: str, scale: float) -> tuple[Outline, ...]:
    from manifold3d import CrossSection, OpType

    bars: list[CrossSection] = []
    left = 0.0
    for letter in text:
        for stroke in _STROKES[letter]:
            width = _NARROW.get(letter, _WIDTH)
            words = [(int(word[0]) / 2, int(word[1]) / 4) for word in stroke.split()]
            corners = [(left + x * width, y * _RISE) for x, y in words]
            bars += [_bar(a, b) for a, b in itertools.pairwise(corners)]
        left += _advance(letter)
    shape = CrossSection.batch_boolean(bars, OpType.Add).scale((scale, scale))
    rings: list[np.ndarray] = cast("Any", shape).to_polygons()
    return tuple(tuple((float(x), float(y)) for x, y in ring) for ring in rings)


def _bar(start: tuple[float, float], end: tuple[float, float]) -> "CrossSection":
    from manifold3d import CrossSection

    square = CrossSection.square((STROKE, STROKE), True)
    return CrossSection.batch_hull([square.translate(start), square.translate(end)])


def _advance(letter: str) -> float:
    return _NARROW.get(letter, _WIDTH) + STROKE + _GAP
