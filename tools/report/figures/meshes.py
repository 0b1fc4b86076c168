"""The links' shapes from the URDF, thinned out for a drawing; none where the URDF has none."""

import contextlib
import io
import logging
import re
from collections.abc import Callable, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ....solver.results import Model
from ....solver.robot import Robot
from .types_drawing import LinkMesh

Shape = tuple[np.ndarray, np.ndarray]
"""Corners, shape (V, 3), and triangles by corner, shape (F, 3)."""
FACES = 600
"""Triangles kept of each link at most."""
LARGEST_FILE = 50_000_000
"""Mesh files beyond this are left out [bytes]."""


def link_meshes(model: Model, robot: Robot) -> tuple[LinkMesh, ...]:
    """Return the triangles that move with the chain, for each frame of the chain.

    Mesh files are looked for where the model's source says; what is not found is left out.

    Args:
        model: The robot's model in the calibration.
        robot: The robot.
    """
    text = model.nominal_urdf
    find = _finder(Path(model.source).parent)
    files = re.findall(r"<mesh\b[^>]*\bfilename\s*=\s*[\"']([^\"']*)", text)
    if not any(map(find, files)) and not re.search("<(box|cylinder|sphere)", text):
        return ()
    if find_spec("yourdfpy") is None:
        logging.getLogger(__name__).warning(
            "yourdfpy cannot be imported, so the report draws the arm as lines"
        )
        return ()
    try:
        scene = _load(text, find)
    except Exception as error:  # a drawing is not worth a report; whatever a mesh reader raises
        logging.getLogger(__name__).info("no meshes: %s", error)
        return ()
    frames = {robot.base: 0, **{joint.child: i + 1 for i, joint in enumerate(robot.joints)}}
    shapes: dict[int, list[Shape]] = {}
    for frame, vertices, faces in _shapes(scene, frames):
        shapes.setdefault(frame, []).append((vertices, faces))
    return tuple(_link_mesh(frame, parts) for frame, parts in sorted(shapes.items()))


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


def _shapes(urdf: Any, index: Mapping[str, int]) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Yield every shape that hangs on a link of the chain: vertices in that link's frame."""
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
        if not hasattr(mesh, "faces") or not len(mesh.faces):
            continue
        vertices = np.asarray(mesh.vertices, dtype=float) @ transform[:3, :3].T + transform[:3, 3]
        yield index[link], vertices, np.asarray(mesh.faces, dtype=np.int64)


def _link_mesh(frame: int, parts: list[Shape]) -> LinkMesh:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = np.concatenate([v for v, _ in parts])
    faces = np.concatenate([f + start for (_, f), start in zip(parts, starts, strict=False)])
    vertices, faces = thin_out(vertices, faces, FACES)
    return LinkMesh(frame=frame, vertices=np.round(vertices, 4).tolist(), faces=faces.tolist())


def thin_out(vertices: np.ndarray, faces: np.ndarray, most: int) -> Shape:
    """Return a mesh of at most so many triangles, by merging the vertices in cells of a grid.

    Args:
        vertices: Shape (V, 3).
        faces: Shape (F, 3).
        most: Triangles allowed.
    """
    size = float(np.ptp(vertices, axis=0).max())
    cells = 64
    while len(faces) > most and cells >= 2:
        keys = np.floor((vertices - vertices.min(axis=0)) / (size / cells)).astype(np.int64)
        _, cell = np.unique(keys, axis=0, return_inverse=True)
        cell = cell.ravel()
        merged = cell[faces]
        distinct = (
            (merged[:, 0] != merged[:, 1])
            & (merged[:, 1] != merged[:, 2])
            & (merged[:, 2] != merged[:, 0])
        )
        merged = merged[distinct]
        _, first = np.unique(np.sort(merged, axis=1), axis=0, return_index=True)
        if len(first) <= most:
            counts = np.bincount(cell)
            means = [np.bincount(cell, vertices[:, k]) / counts for k in range(3)]
            return np.stack(means, axis=1), merged[np.sort(first)]
        cells = cells * 3 // 4
    return vertices, faces[:most]
