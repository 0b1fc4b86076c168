"""From a solid to triangles, by the mesh booleans of manifold3d."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from .solid import Difference, Frustum, Intersection, Moved, Prism, Solid, Sphere, Union

if TYPE_CHECKING:
    from manifold3d import Manifold

SLIVER = 0.0005
"""Thinner triangles are merged into their neighbours: single precision may fold them [mm]."""

CHORD = 0.002
"""Largest distance of a chord from the round surface that it replaces [mm]."""


@dataclass(frozen=True)
class Mesh:
    """A closed surface."""

    vertices: np.ndarray
    """Shape (vertices, 3) [mm], in single precision, as an STL file holds them."""
    triangles: np.ndarray
    """Vertex numbers, anticlockwise from outside, shape (triangles, 3)."""


def to_mesh(manifold: "Manifold") -> Mesh:
    """Return a body's triangles, without those that single precision folds to nothing."""
    mesh: Any = manifold.as_original().simplify(SLIVER).to_mesh()
    rounded = np.asarray(mesh.vert_properties, dtype=np.float32)[:, :3]
    vertices, number = np.unique(rounded, axis=0, return_inverse=True)
    corners = number.ravel()[np.asarray(mesh.tri_verts, dtype=np.int64)]
    folded = (corners == np.roll(corners, 1, axis=1)).any(axis=1)
    return Mesh(vertices, corners[~folded])


@lru_cache(maxsize=128)
def to_manifold(solid: Solid, chord: float = CHORD) -> "Manifold":
    """Evaluate a solid's tree, equal ones once; chords are so far from round surfaces [mm]."""
    from manifold3d import Manifold, OpType

    match solid:
        case Sphere(radius):
            return Manifold.sphere(radius, _segments(radius, chord))
        case Frustum(height, low, high):
            return Manifold.cylinder(height, low, high, _segments(max(low, high), chord))
        case Prism():
            return _prism(solid)
        case Moved(inner, offset):
            body = to_manifold(inner, chord)
            body.num_tri()  # evaluates it: what is moved stands at several places
            return body.translate(offset)
        case Union(parts):
            return Manifold.batch_boolean([to_manifold(p, chord) for p in parts], OpType.Add)
        case Difference(body, tool):
            return to_manifold(body, chord) - to_manifold(tool, chord)
        case Intersection(left, right):
            return to_manifold(left, chord) ^ to_manifold(right, chord)
        case _:
            raise TypeError(f"no such solid: {type(solid).__name__}")


def _prism(prism: Prism) -> "Manifold":
    from manifold3d import CrossSection, Manifold

    section = CrossSection([np.array(outline, dtype=float) for outline in prism.outlines])
    return Manifold.extrude(section, prism.height)


def _segments(radius: float, chord: float) -> int:
    """Return the number of chords for a circle, the same in every third and quarter of it."""
    return 12 * math.ceil(math.pi / math.acos(1 - chord / radius) / 12)
