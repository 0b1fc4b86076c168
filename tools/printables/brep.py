"""From a solid to exact surfaces, by Open CASCADE, and to a STEP file.

Needs the extra ``step``; the Python binding is large, and nothing else here uses it.
"""
# The binding's classes are made at run time; its stubs do not come with all of its versions.

import tempfile
from functools import reduce
from pathlib import Path
from typing import Any

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

Shape = Any
"""A ``TopoDS_Shape``."""


def step_bytes(name: str, solid: Solid) -> bytes:
    """Return a STEP file (AP214, millimetres) of a part."""
    try:
        from OCP import IFSelect, Interface, Message, STEPControl
    except ImportError:
        raise PrintableError(
            "STEP needs Open CASCADE, which is not installed: pip install 'mukca[step]'"
        ) from None
    with tempfile.TemporaryDirectory() as folder:
        shape = to_shape(solid)
        chatter = (
            Message.Message_PrinterOStream.get_type_descriptor_s()
        )  # it would go to standard output
        Message.Message.DefaultMessenger_s().RemovePrinters(chatter)
        writer = STEPControl.STEPControl_Writer()
        Interface.Interface_Static.SetCVal_s("write.step.product.name", name)
        Interface.Interface_Static.SetCVal_s("write.step.unit", "MM")
        writer.Transfer(shape, STEPControl.STEPControl_AsIs)
        path = Path(folder) / f"{name}.step"
        if writer.Write(str(path)) != IFSelect.IFSelect_RetDone:
            raise PrintableError(f"{name}: Open CASCADE could not write it as STEP")
        return path.read_bytes()


def to_shape(solid: Solid) -> Shape:
    """Evaluate a solid's tree to a shape of one body with no superfluous edges."""
    from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

    unify = ShapeUpgrade_UnifySameDomain(_shape(solid), True, True, False)
    unify.Build()
    return _single_body(unify.Shape())


def _shape(solid: Solid) -> Shape:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere

    match solid:
        case Sphere(radius):
            return BRepPrimAPI_MakeSphere(radius).Shape()
        case Frustum():
            return _frustum(solid)
        case Prism():
            return _prism(solid)
        case Moved(inner, offset):
            return _moved(_shape(inner), offset)
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


def _frustum(frustum: Frustum) -> Shape:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCone, BRepPrimAPI_MakeCylinder

    if frustum.low == frustum.high:
        return BRepPrimAPI_MakeCylinder(frustum.low, frustum.height).Shape()
    return BRepPrimAPI_MakeCone(frustum.low, frustum.high, frustum.height).Shape()


def _prism(prism: Prism) -> Shape:
    """Extrude each outline that runs anticlockwise, then cut out those that run clockwise."""
    bodies, holes = (
        [_extruded(o, prism.height) for o in prism.outlines if sign * signed_area(o) > 0]
        for sign in (1, -1)
    )
    return _boolean("Cut", _boolean("Fuse", *bodies), *holes)


def _extruded(outline: Outline, height: float) -> Shape:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Pnt, gp_Vec

    polygon = BRepBuilderAPI_MakePolygon()
    for x, y in outline:
        polygon.Add(gp_Pnt(x, y, 0.0))
    polygon.Close()
    face = BRepBuilderAPI_MakeFace(polygon.Wire(), True).Face()
    return BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, height)).Shape()


def _moved(shape: Shape, offset: tuple[float, float, float]) -> Shape:
    from OCP.gp import gp_Trsf, gp_Vec
    from OCP.TopLoc import TopLoc_Location

    move = gp_Trsf()
    move.SetTranslation(gp_Vec(*offset))
    return shape.Moved(TopLoc_Location(move))


def _boolean(operation: str, body: Shape, *tools: Shape) -> Shape:
    """Combine a shape with others, one by one: ``Fuse``, ``Cut`` or ``Common``."""
    import OCP.BRepAlgoAPI

    combine = getattr(OCP.BRepAlgoAPI, f"BRepAlgoAPI_{operation}")
    return reduce(lambda shape, tool: combine(shape, tool).Shape(), tools, body)


def _single_body(shape: Shape) -> Shape:
    """Return the one solid in a shape."""
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, TopAbs_SOLID)
    bodies: list[Shape] = []
    while explorer.More():
        bodies.append(explorer.Current())
        explorer.Next()
    if len(bodies) != 1:
        raise PrintableError(f"Open CASCADE made {len(bodies)} bodies of the part")
    return bodies[0]
