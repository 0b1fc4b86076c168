"""A part's files: triangles as STL and 3MF, exact surfaces as STEP, and a drawing as SVG."""

import zipfile
from io import BytesIO
from typing import Any

import numpy as np

from ..._version import __version__
from .kernels import COARSE, step_bytes, to_manifold
from .parts import Part, rendered, templates
from .socket_base import SCREW_HOLE

FORMATS = ("stl", "3mf", "svg", "step")
MARGIN, STEP = 28.0, 8.0  # around a view, and between two dimensions


def encode(suffix: str, part: Part, author: str = "mukca") -> bytes:
    """Return a part's file in one of FORMATS; a 3MF file names its author."""
    match suffix:
        # Binary; its unit, which the format does not state, is the millimetre.
        case "stl":
            return (
                b"mukca, millimetres".ljust(80) + part.mesh.export(file_type="stl")[80:]
            )
        case "3mf":
            return _threemf(part, author)
        case "svg":
            return _drawing(part)
        case _:
            return step_bytes(part.name, part.solid)


def _threemf(part: Part, author: str) -> bytes:
    """Return a file by the 3MF Core Specification 1.3, of one object."""
    # trimesh gives its 3MF files new identifiers each time: the same part must make the same file.
    metadata = {
        "Title": part.name,
        "Designer": author,
        "Application": f"mukca {__version__}",
        "LicenseTerms": "Apache-2.0",
        "Description": part.making,
    }
    vertices = part.mesh.vertices.tolist()
    words = {
        "metadata": metadata,
        "vertices": vertices,
        "triangles": part.mesh.faces.tolist(),
    }
    files = {
        "[Content_Types].xml": "content_types.xml",
        "_rels/.rels": "_rels.rels",
        "3D/3dmodel.model": "3dmodel.model.j2",
    }
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, template in files.items():
            text = templates().get_template(template).render(words)
            archive.writestr(zipfile.ZipInfo(path), text, zipfile.ZIP_DEFLATED)
    return stream.getvalue()


def _drawing(part: Part) -> bytes:
    """Return a drawing from the front and from above, with dimensions, holes and notes."""
    values = {"making": part.making, "circles": part.circles, "screw_hole": SCREW_HOLE}
    notes = rendered("notes.txt.j2", part=part.facts, **values)
    body: Any = to_manifold(part.solid, COARSE)
    low, high = np.reshape(np.array(body.bounding_box()), (2, 3))
    wide, _, tall = high - low
    middle = MARGIN - low[0]
    front = MARGIN + tall  # where z = 0 is drawn
    above = front + MARGIN + high[1]
    x_right = MARGIN + wide
    below = above - low[1]
    foot = below + MARGIN + STEP * len(part.spans)
    levels = [(low[2], high[2]), *part.levels]
    dimensions = [  # x and y of both ends
        (x_right + STEP * i, front - a, x_right + STEP * i, front - b)
        for i, (a, b) in enumerate(levels, 1)
    ]
    dimensions += [
        (MARGIN, front + STEP, x_right, front + STEP),
        (MARGIN - STEP, below, MARGIN - STEP, above - high[1]),
    ]
    dimensions += [
        (middle + a, below + STEP * i, middle + b, below + STEP * i)
        for i, (a, b) in enumerate(part.spans, 1)
    ]
    page = templates().get_template("drawing.svg.j2")
    width = x_right + MARGIN + STEP * len(part.levels)
    from_front = _path(body.rotate((-90, 0, 0)), middle, front)
    return page.render(
        title=part.name,
        width=round(max(width, 210), 1),
        height=round(foot + 6 * len(notes) + 6, 1),
        foot=round(foot, 1),
        paths=[from_front, _path(body, middle, above)],
        dimensions=dimensions,
        centre=(round(middle, 2), round(above, 2)),
        right=x_right,
        circles=part.circles,
        balls=[
            (round(middle + ball.x, 2), round(y, 2), ball.diameter / 2, text)
            for ball in part.balls
            for y, text in ((front - ball.z, ""), (above - ball.y, ball.text))
        ],
        notes=notes,
    ).encode()


def _path(body: Any, x: float, y: float) -> str:
    """Return the outline of a body's shadow along z, its origin drawn at x, y."""
    rings = (ring * (1, -1) + (x, y) for ring in body.project().to_polygons())
    texts = (map("{0[0]:.2f} {0[1]:.2f}".format, ring) for ring in rings)
    return "".join(f"M{'L'.join(corners)}Z" for corners in texts)
