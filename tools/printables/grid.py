"""Where the screws go: holes on the grid of an optical table, clear of all that is in the way."""

import itertools
import math
from collections.abc import Iterable, Sequence

PITCH = 25.0
"""Of the grid [mm]."""

Point = tuple[float, float]
Box = tuple[float, float, float, float]
"""Lowest x and y, highest x and y."""
Disc = tuple[float, float, float]
"""x and y of the centre, radius."""


def place_holes(
    area: Box, discs: Sequence[Disc], boxes: Sequence[Box], margin: float
) -> tuple[Point, ...]:
    """Return three or four holes, all on one grid, that hold a plate as widely as possible.

    Of the grid's free points those are taken that are farthest out in the four diagonal directions.
    The grid lies symmetrically about the y axis if that leaves three free points, else anywhere.

    Args:
        area: Where the axes of the holes may lie.
        discs: Where they may not lie.
        boxes: What they must stay clear of.
        margin: By how much.

    Returns:
        The holes, or none where fewer than three fit in.
    """
    blocked = [(x0 - margin, y0 - margin, x1 + margin, y1 + margin) for x0, y0, x1, y1 in boxes]
    best: tuple[Point, ...] = ()
    for columns in ((0.0, PITCH / 2), range(int(PITCH))):
        for x, y in itertools.product(columns, range(int(PITCH))):
            free = [p for p in _grid(area, x, y) if not _is_blocked(p, discs, blocked)]
            best = max(best, _outermost(free), key=_area)
        if len(best) >= 3:
            return best
    return ()


def _grid(area: Box, x: float, y: float) -> Iterable[Point]:
    x0, y0, x1, y1 = area
    columns = range(math.ceil((x0 - x) / PITCH), math.floor((x1 - x) / PITCH) + 1)
    rows = range(math.ceil((y0 - y) / PITCH), math.floor((y1 - y) / PITCH) + 1)
    return ((x + PITCH * i, y + PITCH * j) for i, j in itertools.product(columns, rows))


def _is_blocked(point: Point, discs: Sequence[Disc], boxes: Sequence[Box]) -> bool:
    x, y = point
    return any(math.dist(point, disc[:2]) < disc[2] for disc in discs) or any(
        x0 < x < x1 and y0 < y < y1 for x0, y0, x1, y1 in boxes
    )


def _outermost(points: Sequence[Point]) -> tuple[Point, ...]:
    """Return the points farthest out along the diagonals, in anticlockwise order."""
    if not points:
        return ()
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    corners = [max(points, key=lambda p: (sx * p[0] + sy * p[1], sy * p[1])) for sx, sy in signs]
    return tuple(dict.fromkeys(corners))


def _area(points: Sequence[Point]) -> float:
    """Return the area of a polygon, by the shoelace formula."""
    pairs = zip(points, (*points[1:], *points[:1]), strict=True)
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in pairs) / 2
