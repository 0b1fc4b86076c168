"""From a solid to triangles by manifold3d, to drawings, and to exact surfaces by Open CASCADE.

The last, a STEP file, needs the extra ``step``; its classes are made at run time, without stubs.
"""

import importlib
import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache, reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .solid import (
    Difference,
    Frustum,
    Intersection,
    Moved,
    Outline,
    PrintableError,
    Prism,
    Solid,
    Sphere,
    Union,
    signed_area,
)

if TYPE_CHECKING:
    from jinja2 import Environment
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
    from manifold3d import CrossSection, Manifold, OpType

    match solid:
        case Sphere(radius):
            return Manifold.sphere(radius, _segments(radius, chord))
        case Frustum(height, low, high):
            return Manifold.cylinder(height, low, high, _segments(max(low, high), chord))
        case Prism(outlines, height):
            section = CrossSection([np.array(outline, dtype=float) for outline in outlines])
            return Manifold.extrude(section, height)
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


def _segments(radius: float, chord: float) -> int:
    """Return the number of chords for a circle, the same in every third and quarter of it."""
    return 12 * math.ceil(math.pi / math.acos(1 - chord / radius) / 12)


Shape = Any
"""A ``TopoDS_Shape``."""


def step_bytes(name: str, solid: Solid) -> bytes:
    """Return a STEP file (AP214, millimetres) of a part."""
    step, interface, message = _ocp("STEPControl"), _ocp("Interface"), _ocp("Message")
    unify = _ocp("ShapeUpgrade").ShapeUpgrade_UnifySameDomain(_shape(solid), True, True, False)
    unify.Build()  # no superfluous edges
    chatter = message.Message_PrinterOStream.get_type_descriptor_s()  # goes to standard output
    message.Message.DefaultMessenger_s().RemovePrinters(chatter)
    writer = step.STEPControl_Writer()
    interface.Interface_Static.SetCVal_s("write.step.product.name", name)
    interface.Interface_Static.SetCVal_s("write.step.unit", "MM")
    writer.Transfer(_single_body(unify.Shape()), step.STEPControl_AsIs)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.step"
        if writer.Write(str(path)) != _ocp("IFSelect").IFSelect_RetDone:
            raise PrintableError(f"{name}: Open CASCADE could not write it as STEP")
        return path.read_bytes()


def _ocp(module: str) -> Any:
    """Return a module of the binding."""
    try:
        importlib.import_module("OCP")
        return importlib.import_module(f"OCP.{module}")
    except ImportError:
        raise PrintableError(
            "STEP needs Open CASCADE, which is not installed: pip install 'mukca[step]'"
        ) from None


def _shape(solid: Solid) -> Shape:
    primitives = _ocp("BRepPrimAPI")
    match solid:
        case Sphere(radius):
            return primitives.BRepPrimAPI_MakeSphere(radius).Shape()
        case Frustum(height, low, high) if low == high:
            return primitives.BRepPrimAPI_MakeCylinder(low, height).Shape()
        case Frustum(height, low, high):
            return primitives.BRepPrimAPI_MakeCone(low, high, height).Shape()
        case Prism(outlines, height):  # what runs anticlockwise, less what runs clockwise
            bodies, holes = (
                [_extruded(o, height) for o in outlines if sign * signed_area(o) > 0]
                for sign in (1, -1)
            )
            return _boolean("Cut", _boolean("Fuse", *bodies), *holes)
        case Moved(inner, offset):
            move = _ocp("gp").gp_Trsf()
            move.SetTranslation(_ocp("gp").gp_Vec(*offset))
            return _shape(inner).Moved(_ocp("TopLoc").TopLoc_Location(move))
        case Union(parts):
            return _boolean("Fuse", *map(_shape, parts))
        case Difference(body, Union(parts)):
            return _boolean("Cut", _shape(body), *map(_shape, parts))
        case Difference(body, tool):
            return _boolean("Cut", _shape(body), _shape(tool))
        case Intersection(left, right):
            return _boolean("Common", _shape(left), _shape(right))
        case _:
            raise TypeError(f"no such solid: {type(solid).__name__}")


def _extruded(outline: Outline, height: float) -> Shape:
    builder, points = _ocp("BRepBuilderAPI"), _ocp("gp")
    polygon = builder.BRepBuilderAPI_MakePolygon()
    for x, y in outline:
        polygon.Add(points.gp_Pnt(x, y, 0.0))
    polygon.Close()
    face = builder.BRepBuilderAPI_MakeFace(polygon.Wire(), True).Face()
    up = points.gp_Vec(0.0, 0.0, height)
    return _ocp("BRepPrimAPI").BRepPrimAPI_MakePrism(face, up).Shape()


def _boolean(operation: str, body: Shape, *tools: Shape) -> Shape:
    """Combine a shape with others, one by one: ``Fuse``, ``Cut`` or ``Common``."""
    combine = getattr(_ocp("BRepAlgoAPI"), f"BRepAlgoAPI_{operation}")
    return reduce(lambda shape, tool: combine(shape, tool).Shape(), tools, body)


def _single_body(shape: Shape) -> Shape:
    """Return the one solid in a shape."""
    explorer = _ocp("TopExp").TopExp_Explorer(shape, _ocp("TopAbs").TopAbs_SOLID)
    bodies: list[Shape] = []
    while explorer.More():
        bodies.append(explorer.Current())
        explorer.Next()
    if len(bodies) != 1:
        raise PrintableError(f"Open CASCADE made {len(bodies)} bodies of the part")
    return bodies[0]


MARGIN, STEP = 28.0, 8.0  # around a view, and between two dimensions
COARSE = 0.02  # chords are so far from round lines


@cache
def templates() -> "Environment":
    """Return the templates of files."""
    from jinja2 import Environment, FileSystemLoader

    folder = FileSystemLoader(Path(__file__).parent / "templates")
    return Environment(loader=folder, trim_blocks=True)  # noqa: S701 (texts are escaped one by one)


def rendered(template: str, **values: Any) -> list[str]:
    """Return the lines of a template of text, without those that are empty."""
    text = templates().get_template(template).render(**values)
    return [line for line in text.splitlines() if line]


def drawing_bytes(
    title: str,
    solid: Solid,
    levels: Sequence[tuple[float, float]],
    circles: Sequence[tuple[float, str]],
    notes: Sequence[str],
) -> bytes:
    """Return a drawing with heights between levels, circles of holes by diameter, and notes."""
    body: Any = to_manifold(solid, COARSE)
    low, high = np.reshape(np.array(body.bounding_box()), (2, 3))
    (wide, _, tall), middle = high - low, MARGIN - low[0]
    front = MARGIN + tall  # where z = 0 is drawn
    above = front + MARGIN + high[1]
    foot = above - low[1] + MARGIN
    paths = [
        _path(body.rotate((-90, 0, 0)), middle, front),
        _path(body, middle, above),
    ]
    dimensions = [
        *(
            _dimension(MARGIN + wide + STEP * i, front - a, MARGIN + wide + STEP * i, front - b)
            for i, (a, b) in enumerate(((low[2], high[2]), *levels), 1)
        ),
        _dimension(MARGIN, front + STEP, MARGIN + wide, front + STEP),
        _dimension(MARGIN - STEP, above - low[1], MARGIN - STEP, above - high[1]),
    ]
    words: dict[str, Any] = {
        "title": title,
        "width": round(max(wide + 2 * MARGIN + STEP * len(levels), 210), 1),
        "height": round(foot + 6 * len(notes) + 6, 1),
        "foot": round(foot, 1),
    }
    page = templates().get_template("drawing.svg.j2")
    marks = [
        {
            "x": round(middle, 2),
            "y": round(above, 2),
            "r": d / 2,
            "far": MARGIN + wide + 2,
            "text": t,
        }
        for d, t in circles
    ]
    lines = {"paths": paths, "dimensions": dimensions, "circles": marks, "notes": notes}
    return page.render(**lines, **words).encode()


def _path(body: Any, x: float, y: float) -> str:
    """Return the outline of a body's shadow along z, its origin drawn at x, y."""
    rings = (ring * (1, -1) + (x, y) for ring in body.project().to_polygons())
    return "".join("M" + "L".join(f"{a:.2f} {b:.2f}" for a, b in ring) + "Z" for ring in rings)


def _dimension(x1: float, y1: float, x2: float, y2: float) -> dict[str, Any]:
    """Return a line between two points, upright or level, with its length."""
    upright, text = x1 == x2, f"{abs(x2 - x1) + abs(y2 - y1):.4g}"
    ends = {"x1": x1, "y1": y1, "x2": x2, "y2": y2, "x": (x1 + x2) / 2, "y": (y1 + y2) / 2}
    ends["x" if upright else "y"] -= 1
    return {name: round(float(v), 2) for name, v in ends.items()} | {
        "upright": upright,
        "text": text,
    }
