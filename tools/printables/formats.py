"""The files of a part: STL and 3MF from its triangles, STEP from its exact surfaces."""

import zipfile
from collections.abc import Callable, Mapping
from io import BytesIO

import numpy as np

from .brep import step_bytes
from .mesh import Mesh
from .parts import Part

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
    """Return a 3MF file (3MF Core Specification 1.3) of one object.

    Written here since trimesh gives its 3MF files new identifiers each time: the same part must
    make the same file.
    """
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
