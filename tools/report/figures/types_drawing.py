"""Drawings of the arm in ``report.json``, and errors across placements."""

from ....solver.assessment import Point
from ....solver.results import Document


class Displacement(Document, kw_only=True, frozen=True):
    """Distance between the balls of two models [m]."""

    mean: float
    max: float


class LinkMesh(Document, kw_only=True, frozen=True):
    """The shape of one link."""

    frame: int
    """That it moves with: 0 for the base, i + 1 for the child link of joint i."""
    vertices: list[list[float]]
    """In that frame, shape (V, 3) [m]."""
    faces: list[list[int]]
    """Triangles by vertex, shape (F, 3)."""


class ArmDrawing(Document, kw_only=True, frozen=True):
    """The arm in its recorded configurations, by both models."""

    joints: tuple[str, ...]
    placements: list[int]
    """Of each configuration, the index."""
    nominal: list[list[list[float]]]
    """Places of the joints, shape (configurations, joints + 1, 3) [m]: base first, ball last."""
    calibrated: list[list[list[float]]]
    low: Point
    """Corner of what the calibrated arm fills [m]."""
    high: Point
    reach: float
    """Largest coordinate [m]."""
    displacement: Displacement
    """Of the ball, between the two models."""
    exaggeration: float
    """Factor by which the difference of the models is enlarged at first."""
    meshes: tuple[LinkMesh, ...]
    frames: list[list[list[float]]] | None = None
    """Calibrated link frames, shape (configurations, joints + 1, 12): rows of rotation and
    position; None where there are no meshes."""


class CrossPlacement(Document, kw_only=True, frozen=True):
    """Errors everywhere after training on one placement alone, the paper's Fig. 6."""

    method: str
    names: tuple[str, ...]
    matrix: tuple[tuple[float, ...] | None, ...]
    """[i][j]: MAE on placement j after training on i [m]; None where i cannot be fitted alone."""
