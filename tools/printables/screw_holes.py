"""Places of the screws that hold a plate: on a grid, as far out as posts and letters leave room."""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

from .solid import Point, signed_area

PITCH = 25.0
"""Of the grid [mm]."""


class Box(NamedTuple):
    """A rectangle, by its lowest and its highest x and y."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def middle(self) -> Point:
        """Its centre."""
        return (self.x0 + self.x1) / 2, (self.y0 + self.y1) / 2

    def grown(self, margin: float) -> "Box":
        """Return the rectangle with a margin on all sides."""
        x0, y0, x1, y1 = self
        return Box(x0 - margin, y0 - margin, x1 + margin, y1 + margin)

    def holds(self, point: Point) -> bool:
        """Tell whether a point is inside."""
        x, y = point
        return self.x0 < x < self.x1 and self.y0 < y < self.y1


Disc = tuple[float, float, float]
"""x and y of the centre, radius."""


def place_holes(
    area: Box, discs: Sequence[Disc], boxes: Sequence[Box], margin: float
) -> tuple[Point, ...]:
    """Return 3 or 4 holes, best symmetric about y, that hold a plate widest; none if fewer fit."""
    taken = [box.grown(margin) for box in boxes]

    def is_free(point: Point) -> bool:
        if any(math.dist(point, (x, y)) < radius for x, y, radius in discs):
            return False
        return not any(box.holds(point) for box in taken)

    best: tuple[Point, ...] = ()
    for columns in ((0.0, PITCH / 2), range(int(PITCH))):
        for x, y in itertools.product(columns, range(int(PITCH))):
            columns_of_grid = _steps(x, area.x0, area.x1)
            grid = itertools.product(columns_of_grid, _steps(y, area.y0, area.y1))
            points = list(filter(is_free, grid))
            # Those farthest out along the diagonals, in anticlockwise order.
            corners = [
                max(points, key=lambda p: (sx * p[0] + sy * p[1], sy * p[1]))
                for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))
                if points
            ]
            best = max(best, tuple(dict.fromkeys(corners)), key=signed_area)
        if len(best) >= 3:
            return best
    return ()


def _steps(start: float, low: float, high: float) -> list[float]:
    """Return the numbers of a grid through ``start`` from low to high."""
    first = math.ceil((low - start) / PITCH)
    last = math.floor((high - start) / PITCH)
    return [start + PITCH * i for i in range(first, last + 1)]
