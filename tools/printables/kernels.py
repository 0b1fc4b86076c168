"""From a solid to triangles by manifold3d, and to exact surfaces by Open CASCADE.

The last, a STEP file, needs the extra ``step``; its classes are made at run time, without stubs.
"""

import importlib
import math
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .solid import Outline, PrintableError, Solid, signed_area

if TYPE_CHECKING:
    from manifold3d import Manifold

SLIVER = 0.0005
"""Thinner triangles are merged into their neighbours: single precision may fold them [mm]."""

CHORD = 0.002
"""Largest distance of a chord from the round surface that it replaces [mm]."""

COARSE = 0.02
"""The same in drawings, and where a part leans."""

Mesh = Any
"""A ``trimesh.Trimesh`` [mm], its vertices in single precision, as an STL file holds them."""


def to_mesh(manifold: "Manifold") -> Mesh:
    """Return a body's triangles, without those that single precision folds to nothing."""
    import trimesh

    simplified = manifold.as_original().simplify(SLIVER)
    mesh: Any = simplified.to_mesh()
    properties = np.asarray(mesh.vert_properties, dtype=np.float32)
    triangles = np.asarray(mesh.tri_verts, dtype=np.int64)
    vertices, number = np.unique(properties[:, :3], axis=0, return_inverse=True)
    corners = number.ravel()[triangles]
    next_corners = np.roll(corners, 1, axis=1)
    folded = (corners == next_corners).any(axis=1)
    return trimesh.Trimesh(vertices, corners[~folded], process=False)


@lru_cache(maxsize=128)
def to_manifold(solid: Solid, chord: float = CHORD) -> "Manifold":
    """Evaluate a solid's tree, equal ones once; chords are so far from round surfaces [mm]."""
    from manifold3d import CrossSection, Manifold, OpType

    parts = [to_manifold(part, chord) for part in solid.parts]
    match solid.kind, *solid.numbers:
        case "sphere", radius:
            return Manifold.sphere(radius, _segments(radius, chord))
        case "frustum", height, low, high:
            count = _segments(max(low, high), chord)
            return Manifold.cylinder(height, low, high, count)
        case "prism", height, *outlines:
            polygons = [np.array(outline, dtype=float) for outline in outlines]
            return Manifold.extrude(CrossSection(polygons), height)
        case "moved", *offset:
            parts[0].num_tri()  # evaluates it: what is moved stands at several places
            return parts[0].translate(offset)
        case "leaned", lean, azimuth:
            angles = (0.0, math.degrees(lean), math.degrees(azimuth))
            return parts[0].rotate(angles)
        case _:
            return Manifold.batch_boolean(parts, OpType.__members__[solid.kind])


def _segments(radius: float, chord: float) -> int:
    """Return the number of chords for a circle, the same in every third and quarter of it."""
    fewest = math.pi / math.acos(1 - chord / radius)
    return 12 * math.ceil(fewest / 12)


Shape = Any
"""A ``TopoDS_Shape``."""


def step_bytes(name: str, solid: Solid) -> bytes:
    """Return a STEP file (AP214, millimetres) of a part."""
    unify = _occ("ShapeUpgrade_UnifySameDomain")(_shape(solid), True, True, False)
    unify.Build()
    explorer = _occ("TopExp_Explorer")(unify.Shape(), _occ("TopAbs_SOLID"))
    body = explorer.Current() if explorer.More() else None
    explorer.Next()
    if body is None or explorer.More():
        raise PrintableError(f"{name}: Open CASCADE does not make one body of it")
    # What Open CASCADE says goes to standard output.
    chatter = _occ("Message_PrinterOStream").get_type_descriptor_s()
    _occ("Message").DefaultMessenger_s().RemovePrinters(chatter)
    writer = _occ("STEPControl_Writer")()
    for key, text in (("product.name", name), ("unit", "MM")):
        _occ("Interface_Static").SetCVal_s(f"write.step.{key}", text)
    writer.Transfer(body, _occ("STEPControl_AsIs"))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.step"
        if writer.Write(str(path)) != _occ("IFSelect_RetDone"):
            raise PrintableError(f"{name}: Open CASCADE could not write it as STEP")
        return path.read_bytes()


def _occ(name: str) -> Any:
    """Return a class or constant of Open CASCADE; its name begins with its module's."""
    module_name, _, _ = name.partition("_")
    try:
        importlib.import_module("OCP")
        return getattr(importlib.import_module(f"OCP.{module_name}"), name)
    except ImportError:
        raise PrintableError(
            "STEP needs Open CASCADE, which is not installed: pip install 'mukca[step]'"
        ) from None


def _shape(solid: Solid) -> Shape:
    parts = [_shape(part) for part in solid.parts]
    match solid.kind, *solid.numbers:
        case "sphere", radius:
            return _occ("BRepPrimAPI_MakeSphere")(radius).Shape()
        case "frustum", height, low, high if low == high:
            return _occ("BRepPrimAPI_MakeCylinder")(low, height).Shape()
        case "frustum", height, low, high:
            return _occ("BRepPrimAPI_MakeCone")(low, high, height).Shape()
        # What runs anticlockwise, less what runs clockwise.
        case "prism", height, *outlines:
            bodies = [_extruded(o, height) for o in outlines if signed_area(o) > 0]
            holes = [_extruded(o, height) for o in outlines if signed_area(o) < 0]
            return _boolean("Cut", [_boolean("Fuse", bodies), *holes])
        case "moved", *offset:
            vector = _occ("gp_Vec")(*offset)
            move = _occ("gp_Trsf")()
            move.SetTranslation(vector)
            return parts[0].Moved(_occ("TopLoc_Location")(move))
        case "leaned", lean, azimuth:
            about_y = _turn((0, 1, 0), lean)
            about_z = _turn((0, 0, 1), azimuth)
            lean_then_turn = _occ("TopLoc_Location")(about_z.Multiplied(about_y))
            return parts[0].Moved(lean_then_turn)
        case _:
            kinds = {"Add": "Fuse", "Subtract": "Cut", "Intersect": "Common"}
            return _boolean(kinds[solid.kind], parts)


def _turn(axis: tuple[int, int, int], angle: float) -> Any:
    """Return a turn about an axis through the origin."""
    origin = _occ("gp_Pnt")(0, 0, 0)
    line = _occ("gp_Ax1")(origin, _occ("gp_Dir")(*axis))
    turn = _occ("gp_Trsf")()
    turn.SetRotation(line, angle)
    return turn


def _extruded(outline: Outline, height: float) -> Shape:
    polygon = _occ("BRepBuilderAPI_MakePolygon")()
    for x, y in outline:
        polygon.Add(_occ("gp_Pnt")(x, y, 0.0))
    polygon.Close()
    face = _occ("BRepBuilderAPI_MakeFace")(polygon.Wire(), True)
    upwards = _occ("gp_Vec")(0.0, 0.0, height)
    return _occ("BRepPrimAPI_MakePrism")(face.Face(), upwards).Shape()


def _boolean(operation: str, shapes: Sequence[Shape]) -> Shape:
    """Combine the first shape with the others, one by one: ``Fuse``, ``Cut`` or ``Common``."""
    combine = _occ(f"BRepAlgoAPI_{operation}")
    combined, *tools = shapes
    for tool in tools:
        combined = combine(combined, tool).Shape()
    return combined
