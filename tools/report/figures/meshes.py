"""Shapes of the links from the URDF, thinned out for a drawing; none where the URDF has none."""

import contextlib
import io
import logging
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ....solver.results import Model
from ....solver.robot import Robot
from .types import LinkMesh

FACES = 600
"""Triangles kept of each link at most."""
LARGEST_FILE = 50_000_000
"""Mesh files beyond this are left out [bytes]."""


def link_meshes(model: Model, robot: Robot) -> tuple[LinkMesh, ...]:
    """Return the triangles that move with each frame of the chain.

    Mesh files are looked for at the model's source; those not found are left out.
    """
    text = model.nominal_urdf
    find = _finder(Path(model.source).parent)
    files = re.findall(r"<mesh\b[^>]*\bfilename\s*=\s*[\"']([^\"']*)", text)
    if not any(map(find, files)) and not re.search("<(box|cylinder|sphere)", text):
        return ()
    import trimesh

    frames = {robot.base: 0, **{joint.child: i + 1 for i, joint in enumerate(robot.joints)}}
    shapes: dict[int, list[Any]] = {}
    try:
        for frame, mesh in _shapes(_load(text, find), frames):
            shapes.setdefault(frame, []).append(mesh)
    except Exception as error:  # a drawing is not worth a report; whatever a mesh reader raises
        logging.getLogger(__name__).info("no meshes: %s", error)
        return ()
    util: Any = trimesh.util
    meshes = {frame: util.concatenate(parts) for frame, parts in sorted(shapes.items())}
    return tuple(_link_mesh(frame, mesh) for frame, mesh in meshes.items())


def _load(text: str, find: Callable[[str], str]) -> Any:
    import yourdfpy  # pyright: ignore[reportMissingTypeStubs]

    for name in ("yourdfpy", "trimesh"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        return yourdfpy.URDF.load(  # pyright: ignore[reportUnknownMemberType]
            io.BytesIO(text.encode()), filename_handler=find, load_meshes=True
        )


def _finder(folder: Path) -> Callable[[str], str]:
    """Return a search for mesh files: beside the model, or, for ``package://``, above it."""

    def find(fname: str) -> str:
        scheme, _, rest = fname.rpartition("://")
        if scheme in ("", "file"):
            candidates = [folder / rest]
        else:
            inside = Path(*Path(rest).parts[1:])
            candidates = [up / part for up in folder.resolve().parents for part in (rest, inside)]
            candidates.append(folder / inside)
        for file in candidates:
            if file.is_file() and file.stat().st_size <= LARGEST_FILE:
                return str(file)
        return ""

    return find


def _shapes(urdf: Any, index: Mapping[str, int]) -> Iterator[tuple[int, Any]]:
    """Yield every mesh that hangs on a link of the chain, in that link's frame."""
    graph = urdf.scene.graph
    parents = graph.transforms.parents
    for node in graph.nodes_geometry:
        link = node
        while link not in index and link in parents:
            link = parents[link]
        if link not in index:
            continue
        transform, geometry = graph.get(node, link)
        mesh = urdf.scene.geometry[geometry]
        if hasattr(mesh, "faces") and len(mesh.faces):
            yield index[link], mesh.copy().apply_transform(transform)


def _link_mesh(frame: int, mesh: Any) -> LinkMesh:
    """Return a mesh with the vertices in each cell of a grid merged, the finest with few faces."""
    import trimesh

    thin, cells = mesh, 64
    while len(thin.faces) > FACES and cells >= 2:
        grid = np.floor((mesh.vertices - mesh.bounds[0]) * (cells / mesh.extents.max()))
        _, cell = np.unique(grid, axis=0, return_inverse=True)
        means = np.stack([np.bincount(cell.ravel(), v) for v in mesh.vertices.T], axis=1)
        means /= np.bincount(cell.ravel())[:, None]
        thin = trimesh.Trimesh(means, cell.ravel()[mesh.faces], process=False)
        thin.update_faces(thin.nondegenerate_faces() & thin.unique_faces())
        cells = cells * 3 // 4
    vertices = np.round(thin.vertices, 4).tolist()
    return LinkMesh(frame=frame, vertices=vertices, faces=thin.faces[:FACES].tolist())
