"""A set of parts, the base and the balls that go with it: built, checked, and as files."""

import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any

import numpy as np

from .anchor import ARMS, AnchoredBase
from .ball import BallPart
from .brep import step_bytes
from .checks import check_body, check_tilt
from .mesh import Mesh, to_manifold, to_mesh
from .socket_base import SocketBase
from .solid import TILT, PrintableError, Solid

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_MODEL = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
_CONTENT_TYPES = (
    f'<?xml version="1.0" encoding="UTF-8"?><Types xmlns="{_PACKAGE}/content-types">'
    '<Default Extension="rels" '
    'ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    f'<?xml version="1.0" encoding="UTF-8"?><Relationships xmlns="{_PACKAGE}/relationships">'
    '<Relationship Target="/3D/3dmodel.model" Id="part" '
    'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)


@dataclass(frozen=True)
class Part:
    """A part that passed its checks."""

    name: str
    """Of its files, without the suffix."""
    solid: Solid
    mesh: Mesh
    facts: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Properties of it, in SI units, as JSON has them."""


def build_parts(base: SocketBase, balls: Mapping[str, BallPart]) -> Iterator[Part]:
    """Build and check a socket base and the ball parts for it, one after the other.

    Args:
        base: The socket base.
        balls: The ball parts by name.

    Raises:
        PrintableError: A part cannot be printed, or hits the base when it leans.
    """
    yield base_part(base)
    if isinstance(base, AnchoredBase):
        yield _checked(part_names(base)[1], base.fit_test(), {})
    for name, ball in balls.items():
        try:
            check_tilt(base, ball)
        except PrintableError as error:
            raise PrintableError(f"{name}: {error}") from None
        yield ball_part(name, ball)


def part_names(base: SocketBase) -> list[str]:
    """Return the names of the parts that a base consists of."""
    return [base.name, f"fit-test-{base.arm}"] if isinstance(base, AnchoredBase) else [base.name]


def base_part(base: SocketBase) -> Part:
    """Build and check a socket base."""
    facts: dict[str, Any] = {
        "distance": base.distance / 1000,
        "ball_diameter": base.ball / 1000,
        "sockets": [[x / 1000, y / 1000, base.height / 1000] for x, y in base.centres],
        "holes": [[x / 1000, y / 1000] for x, y in base.holes],
        "caliper": {"outside": base.outside / 1000, "inside": base.inside / 1000},
    }
    if isinstance(base, AnchoredBase):
        facts["sockets_in_base"] = [[x / 1000 for x in place] for place in base.sockets_in_base]
        facts["second_axis_height"] = ARMS[base.arm].shoulder / 1000
    return _checked(base.name, base.solid(), facts)


def ball_part(name: str, ball: BallPart) -> Part:
    """Build a ball part, and check it by itself."""
    facts = {
        "ball": [x / 1000 for x in ball.position],
        "ball_diameter": ball.ball / 1000,
        "bought_ball": ball.bought,
        "flanges": dict(ball.mount.links),
        "note": ball.mount.note,
        "bend": ball.bend / 1000,
        "tilt": TILT,
        "overhangs": [overhang.where for overhang in ball.overhangs],
    }
    return _checked(name, ball.solid(), facts)


def _checked(name: str, solid: Solid, facts: Mapping[str, Any]) -> Part:
    body = to_manifold(solid)
    mesh = to_mesh(body)
    check_body(name, body, mesh)
    size = [round(float(edge) / 1000, 7) for edge in np.ptp(mesh.vertices, axis=0)]
    common = {"name": name, "size": size, "volume": body.volume() * 1e-9}
    return Part(name, solid, mesh, {**common, **facts})


def stl_bytes(mesh: Mesh) -> bytes:
    """Return a binary STL file; its unit, which the format does not state, is the millimetre."""
    corners = mesh.vertices[mesh.triangles].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    facets = np.zeros(len(corners), _FACET)
    facets["normal"] = normals / np.where(lengths > 0, lengths, 1)
    facets["corners"] = corners
    header = b"mukca, millimetres".ljust(80)
    return header + len(facets).to_bytes(4, "little") + facets.tobytes()


def threemf_bytes(name: str, mesh: Mesh) -> bytes:
    """Return a 3MF file (3MF Core Specification 1.3) of one object."""
    # trimesh gives its 3MF files new identifiers each time: the same part must make the same file.
    points = ((f"{x:.9g}", f"{y:.9g}", f"{z:.9g}") for x, y, z in mesh.vertices)
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in points)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.triangles)
    model = (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<model unit="millimeter" xml:lang="en" xmlns="{_MODEL}"><resources>'
        f'<object id="1" type="model" name="{name}"><mesh><vertices>{vertices}</vertices>'
        f"<triangles>{triangles}</triangles></mesh></object></resources>"
        '<build><item objectid="1"/></build></model>'
    )
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, text in (
            ("[Content_Types].xml", _CONTENT_TYPES),
            ("_rels/.rels", _RELATIONS),
            ("3D/3dmodel.model", model),
        ):
            archive.writestr(zipfile.ZipInfo(path), text, zipfile.ZIP_DEFLATED)
    return stream.getvalue()


_ENCODERS: Mapping[str, Callable[[Part], bytes]] = {
    "stl": lambda part: stl_bytes(part.mesh),
    "3mf": lambda part: threemf_bytes(part.name, part.mesh),
    "step": lambda part: step_bytes(part.name, part.solid),
}
FORMATS = tuple(_ENCODERS)


def encode(suffix: str, part: Part) -> bytes:
    """Return a part's file in one of FORMATS.

    Raises:
        PrintableError: STEP without the package that writes it.
    """
    return _ENCODERS[suffix](part)
