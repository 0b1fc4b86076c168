"""All figures of a report, worked out from a calibration; the drawing of the arm is one of them."""

import contextlib
import io
import logging
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import MukcaError
from ....solver import assessment
from ....solver.identification.data import Measurement, as_point, evaluate
from ....solver.identification.paper import (
    REGULARIZATION,
    Problem,
    build_problem,
    solve,
)
from ....solver.identification.robot import Robot, all_parameters, link_poses, urdf_of
from ....solver.results import Model
from . import types
from .answers import answers_of
from .command_lines import solve_command
from .recommendations import steps

FACES = 600
"""Triangles kept of each link at most."""
LARGEST_FILE = 50_000_000
"""Mesh files beyond this are left out [bytes]."""
FORMATS = (".stl", ".dae", ".ply", ".obj")
"""Endings of mesh files that are read; archives are not."""


def link_meshes(model: Model, robot: Robot) -> tuple[types.LinkMesh, ...]:
    """Return the triangles that move with each frame, of those files that are at the model's."""
    text = model.nominal_urdf
    find = _finder(Path(urdf_of(model.source)).parent)
    files = re.findall(r"<mesh\b[^>]*\bfilename\s*=\s*[\"']([^\"']*)", text)
    if not any(map(find, files)) and not re.search("<(box|cylinder|sphere)", text):
        return ()
    import trimesh
    import yourdfpy  # pyright: ignore[reportMissingTypeStubs]

    for name in ("yourdfpy", "trimesh"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    links = [robot.base, *(joint.child for joint in robot.joints)]
    frames = {link: frame for frame, link in enumerate(links)}
    shapes: dict[int, list[Any]] = {}
    try:
        with (
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(io.StringIO()),
        ):
            urdf: Any = yourdfpy.URDF.load(  # pyright: ignore[reportUnknownMemberType]
                io.BytesIO(text.encode()), filename_handler=find, load_meshes=True
            )
        for frame, mesh in _shapes(urdf, frames):
            shapes.setdefault(frame, []).append(mesh)
    except (
        Exception
    ) as error:  # a drawing is not worth a report; whatever a mesh reader raises
        logging.getLogger(__name__).info("no meshes: %s", error)
        return ()
    util: Any = trimesh.util
    meshes = {frame: util.concatenate(parts) for frame, parts in sorted(shapes.items())}
    return tuple(_link_mesh(frame, mesh) for frame, mesh in meshes.items())


def _finder(folder: Path) -> Callable[[str], str]:
    """Return a search for mesh files: beside the model, or, for ``package://``, above it.

    A file elsewhere, or that a link leads to elsewhere, is not read: see :func:`_own_folder`.
    """
    here = folder.resolve()
    own_folder = _own_folder(here)
    above = [up for up in (here, *here.parents) if up.is_relative_to(own_folder)]

    def find(fname: str) -> str:
        scheme, _, path = fname.rpartition("://")
        inside = Path(*Path(path).parts[1:])
        candidates = [here / path]
        if scheme not in ("", "file"):
            candidates = [up / part for up, part in product(above, (path, inside))]
        for file in filter(Path.is_file, candidates):
            if not file.resolve().is_relative_to(own_folder):
                log = logging.getLogger(__name__)
                log.warning("%r is not drawn: not in %r", fname, str(own_folder))
            elif file.suffix.lower() in FORMATS and file.stat().st_size <= LARGEST_FILE:
                return str(file)
        return ""

    return find


def _own_folder(folder: Path) -> Path:
    """Return the folder that holds a model's files: its package, or the one above ``urdf``."""
    for up in (folder, *folder.parents):
        if (up / "package.xml").is_file():
            return up
    return folder.parent if folder.name == "urdf" else folder


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


def _link_mesh(frame: int, mesh: Any) -> types.LinkMesh:
    """Return a mesh with the vertices in each cell of a grid merged, the finest with few faces."""
    import trimesh

    thin = mesh
    cells = 64
    while len(thin.faces) > FACES and cells >= 2:
        grid = np.floor((mesh.vertices - mesh.bounds[0]) * (cells / mesh.extents.max()))
        _, cell = np.unique(grid, axis=0, return_inverse=True)
        cell = cell.ravel()
        sums = [np.bincount(cell, coordinate) for coordinate in mesh.vertices.T]
        means = np.transpose(sums / np.bincount(cell))
        thin = trimesh.Trimesh(means, cell[mesh.faces], process=False)
        thin.update_faces(thin.nondegenerate_faces() & thin.unique_faces())
        cells = cells * 3 // 4
    vertices = np.round(thin.vertices, 4).tolist()
    return types.LinkMesh(
        frame=frame, vertices=vertices, faces=thin.faces[:FACES].tolist()
    )


CONFIGURATIONS = 400
"""Configurations drawn at most: of more, every second, third, ..."""
SHOWN_SHIFT = 0.05
"""The view first enlarges the difference of the two models to this share of the arm's reach."""


def arm_drawing(predictions: assessment.Predictions) -> types.ArmDrawing:
    """Return the skeletons of both models, and meshes where there are any."""
    robot = predictions.robot
    calibration = predictions.calibration
    placements = predictions.placements
    measured = [placement.measured for placement in placements]
    counts = [len(placement.samples) for placement in placements]
    owners = np.repeat(np.arange(len(placements)), counts)
    q = np.concatenate([m.positions for m in measured])
    true = [calibration.true_positions(m.positions, m.efforts) for m in measured]
    points = [placement.points for placement in placements]
    changes = np.concatenate([p.nominal - p.calibrated for p in points])
    distances = np.linalg.norm(changes, axis=1)
    rows = np.arange(0, len(q), -(-len(q) // CONFIGURATIONS))
    nominal = link_poses(robot.joints, q[rows])
    origins = calibration.model.origins(calibration.values)
    calibrated = link_poses(robot.joints, np.concatenate(true)[rows], origins)
    places = calibrated[..., 3]
    reach = float(np.abs(places).max())
    mean = float(distances.mean())
    factor = 1.0  # that makes the difference visible, if it can be
    if mean >= 1e-7:
        factor = max(1.0, assessment.nice_above(SHOWN_SHIFT * reach / mean / 2))
    meshes = link_meshes(predictions.document.model, robot)
    drawing = np.round(calibrated, 4).reshape(len(rows), -1, 12).tolist()
    return types.ArmDrawing(
        joints=tuple(joint.name for joint in robot.joints),
        placements=owners[rows].tolist(),
        nominal=np.round(nominal[..., 3], 5).tolist(),
        calibrated=np.round(places, 5).tolist(),
        low=as_point(places.min(axis=(0, 1)).round(4)),
        high=as_point(places.max(axis=(0, 1)).round(4)),
        reach=reach,
        displacement=types.Displacement(mean=mean, max=float(distances.max())),
        exaggeration=factor,
        meshes=meshes,
        frames=drawing if meshes else None,
    )


def report_figures(assessment_of_fit: assessment.Assessment) -> types.ReportDocument:
    """Return the figures of a report, without plots."""
    assessed = dict(vars(assessment_of_fit))
    predictions: assessment.Predictions = assessed.pop("predictions")
    document = predictions.document
    samples = assessment.sample_errors(predictions)
    return types.ReportDocument.filled(
        document,
        format=types.REPORT,
        robot_name=predictions.robot.name,
        **assessed,
        samples=samples,
        cross_placement=cross_placement(predictions),
        distance_text=assessment.distance_text(document.placements),
        provenance=types.ReportProvenance.filled(
            document.provenance, settings=document.settings
        ),
        command=solve_command(document),
        rests_on=assessment_of_fit.verdict.rests_on,
        todo=tuple(steps(assessment_of_fit)),
        answers=answers_of(assessment_of_fit, samples),
        arm=arm_drawing(predictions),
        plots=(),
    )


def cross_placement(predictions: assessment.Predictions) -> types.CrossPlacement | None:
    """Return the errors everywhere by models trained on each placement alone; None for only one."""
    placements = predictions.placements
    weight = assessment.setting(
        predictions.document, predictions.source, "regularization"
    )
    if len(placements) < 2:
        return None
    # By Eq. (5), some 10 ms each, with the joint origins that the calibration itself had free.
    names = {parameter.name for parameter in predictions.calibration.parameters}
    problem = build_problem(
        predictions.robot,
        [placement.measured for placement in placements],
        parameters=[p for p in all_parameters(predictions.robot) if p.name in names],
        regularization=REGULARIZATION if weight is None else weight,
    )
    return types.CrossPlacement(
        method="Eq. (5)",
        names=tuple(placement.name for placement in placements),
        matrix=tuple(_row(problem, placement.measured) for placement in placements),
    )


def _row(problem: Problem, trained_on: Measurement) -> tuple[float, ...] | None:
    if not trained_on.has_distance:
        return None
    try:
        x = solve(replace(problem, training=(trained_on,))).x
    except MukcaError:
        return None
    return tuple(
        evaluate(problem.model.points(x, m.positions), m).mean_absolute_error
        for m in problem.training
    )
