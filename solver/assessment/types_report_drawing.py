"""What ``report.json`` holds for its drawings: where the joints were, and where the arm was."""

from typing import Literal

from ..results import Document
from ..results.calibration import Role
from .types_report_errors import Point


class JointRange(Document, kw_only=True, frozen=True):
    """A joint and its limits."""

    name: str
    unit: Literal["rad", "m"]
    lower: float | None
    upper: float | None


class SocketCoverage(Document, kw_only=True, frozen=True):
    """Where the joints were in one socket [rad, m for prismatic joints]."""

    placement: str
    role: Role
    socket: int
    low: tuple[float, ...]
    """Smallest position of each joint."""
    high: tuple[float, ...]
    positions: tuple[tuple[float, ...], ...]
    """Of the samples, thinned out where there are many; shape (N, joints)."""


class Coverage(Document, kw_only=True, frozen=True):
    """How far each joint moved in each socket."""

    joints: tuple[JointRange, ...]
    sockets: tuple[SocketCoverage, ...]


class Displacement(Document, kw_only=True, frozen=True):
    """How far apart two models put the ball [m]."""

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
    """How many times the difference of the models is enlarged at first."""
    meshes: tuple[LinkMesh, ...]
    frames: list[list[list[float]]] | None = None
    """Where there are meshes, the calibrated link frames, shape (configurations, joints + 1, 12):
    the rows of rotation and place."""
