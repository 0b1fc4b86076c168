"""Solids as data: primitives and set operations in one small tree, and the limits of all parts.

A part is described once, and evaluated by two :mod:`.kernels`. Lengths are millimetres; z is up.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ...errors import MukcaError

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
