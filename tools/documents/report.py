"""What ``report.json`` holds: every number and sentence that the report's page shows.

Lengths are metres, angles radians. Points are in the robot's base frame: x ahead, y to the left.
"""

import math
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar

from ...solver.checks.inspection import Finding
from .calibration import (
    Coefficient,
    Iteration,
    NextPlacement,
    NoiseScale,
    ParameterValue,
    PlacementErrors,
    PriorWidth,
    Provenance,
    Role,
    Summary,
    Uncertainty,
)
from .files import Document, read

__all__ = [
    "FORMAT",
    "Answer",
    "Answers",
    "ArmDrawing",
    "ByModel",
    "Coverage",
    "CrossPlacement",
    "DataAnswer",
    "Displacement",
    "JointRange",
    "KnownDistanceErrors",
    "Limit",
    "LimitResult",
    "Limits",
    "LinkMesh",
    "LoneFit",
    "ModelName",
    "NextAnswer",
    "PlacementReport",
    "PlotCaption",
    "Point",
    "Quantiles",
    "ReportDocument",
    "ReportProvenance",
    "RoleSummaries",
    "RoleSummary",
    "SampleErrors",
    "Socket",
    "SocketCoverage",
    "UseAnswer",
    "UseAtPlacement",
    "Verdict",
    "WorstSample",
    "read_report",
]

FORMAT = "mukca-report-1"
ModelName = Literal["nominal", "calibrated"]
Answer = Literal["yes", "mostly", "no", "trained on"]
"""``mostly``: 19 of 20 samples; ``trained on``: its errors prove nothing."""
Value = TypeVar("Value")
Point = tuple[float, float, float]


class ByModel(Document, Generic[Value], kw_only=True, frozen=True):
    """The same figure by the nominal and by the calibrated model."""

    nominal: Value
    calibrated: Value

    def of(self, model: ModelName) -> Value:
        """Return the figure of one model."""
        return self.nominal if model == "nominal" else self.calibrated


class Quantiles(Document, kw_only=True, frozen=True):
    """How errors of single samples are distributed [m]."""

    median: float
    p95: float
    """19 of 20 samples have no larger error."""
    max: float


class RoleSummary(Summary, kw_only=True, frozen=True):
    """All placements of one role (trained on, or held out) taken together."""

    placements: int
    samples: int
    quantiles: ByModel[Quantiles]
    within_tolerance: ByModel[float]
    """Share of the samples whose error is within the task's tolerance, 0 to 1."""


class RoleSummaries(Document, kw_only=True, frozen=True):
    """A summary for each role; None where no placement has it."""

    train: RoleSummary | None
    test: RoleSummary | None

    @property
    def judged(self) -> tuple[Role, RoleSummary]:
        """The role that verdicts rest on: held out; without any such placement, trained on."""
        if self.test is not None:
            return "test", self.test
        assert self.train is not None  # a report has at least one placement
        return "train", self.train


class Socket(Document, kw_only=True, frozen=True):
    """Where the calibrated model puts a socket."""

    socket: int
    centre: Point
    """Mean of the predicted ball centres [m]."""


class PlacementReport(PlacementErrors, kw_only=True, frozen=True):
    """One placement: its errors, and where it stands."""

    position: Point
    """The middle of its sockets [m]."""
    sockets: tuple[Socket, ...]
    quantiles: ByModel[Quantiles]
    within_tolerance: float
    """Share of the samples within the task's tolerance, by the calibrated model."""


class KnownDistanceErrors(Document, kw_only=True, frozen=True):
    """A distance between two sockets that was measured from outside, and how far models are off."""

    a: str
    """``PLACEMENT:SOCKET``."""
    b: str
    distance: float
    """As measured [m]."""
    standard_deviation: float
    """Of the measurement [m]."""
    in_fit: bool
    """Whether the calibration was fitted to it: then it proves nothing."""
    nominal_error: float
    """Predicted less measured [m]."""
    calibrated_error: float

    def error(self, model: ModelName) -> float:
        """Return the error of one model [m]."""
        return self.nominal_error if model == "nominal" else self.calibrated_error


class Limit(Document, kw_only=True, frozen=True):
    """The largest value that passes."""

    value: float | None
    """[m]; None where nothing says what is good for this arm."""
    source: str
    """Where it comes from, or what is needed to have it."""


class Limits(Document, kw_only=True, frozen=True):
    """What a calibration is held against."""

    repeatability: float | None
    """How well the arm comes back to the same place [m], where it is known."""
    repeatability_source: str
    mean_absolute_error: Limit
    distance_error: Limit
    between_placements: Limit


class LimitResult(Document, kw_only=True, frozen=True):
    """One limit of the verdict, and whether it is kept."""

    name: str
    title: str
    found: float | None
    """What the calibration reaches [m]."""
    limit: float | None
    """[m]."""
    status: Literal["pass", "fail", "not evaluated"]
    text: str
    reason: str
    """Where the limit comes from, or what is missing."""


class Verdict(Document, kw_only=True, frozen=True):
    """Whether the calibration keeps its limits."""

    status: Literal["pass", "fail", "incomplete"]
    title: str
    text: str
    limits: tuple[LimitResult, ...]


class UseAtPlacement(Document, kw_only=True, frozen=True):
    """May the arm be used for the task at this placement?"""

    name: str
    called: str
    """Its name, with the robot's side where it is on one."""
    where: str
    answer: Answer


class UseAnswer(Document, kw_only=True, frozen=True):
    """The answer to "May I use this arm for my task?"."""

    rows: tuple[UseAtPlacement, ...]
    text: str
    meaning: str
    """What error is meant."""
    alone: str | None
    """How the exported URDF does by itself, where it is not the full model."""
    between: str
    """What is known of points that were not taught at the place itself."""
    cannot_see: tuple[str, ...]
    """What a ball in a socket cannot tell."""


class NextAnswer(Document, kw_only=True, frozen=True):
    """The answer to "Which placement next?"."""

    text: str
    train_on: str | None
    """A placement that is recorded already, and worth training on too."""
    place: Point
    """Where to record a new one [m]."""
    joints: tuple[str, ...]
    """Those that hardly moved."""


class WorstSample(Document, kw_only=True, frozen=True):
    """A sample far from its socket."""

    where: str
    """File and line."""
    name: str
    """Of its placement."""
    socket: int
    number: int
    """Its place among the samples of its socket, from 1."""
    weight: float | None
    """Robust weight in the fit; None where there was none."""
    error: float
    """Distance from its socket's centre by the calibrated model [m]."""
    ratio: float
    """That distance over the mean of its placement."""


class LoneFit(Document, kw_only=True, frozen=True):
    """What error a placement keeps when the model is fitted to it alone."""

    name: str
    mean_absolute_error: float


class DataAnswer(Document, kw_only=True, frozen=True):
    """The answer to "Is my data all right?"."""

    text: str
    worst: tuple[WorstSample, ...]
    floors: tuple[LoneFit, ...]


class Answers(Document, kw_only=True, frozen=True):
    """The answers to the three questions that a user has."""

    use: UseAnswer
    next: NextAnswer
    data: DataAnswer


class SampleErrors(Document, kw_only=True, frozen=True):
    """One sample: the predicted ball centre less the mean of its socket, by both models [m]."""

    placement: int
    """Index of its placement."""
    socket: int
    number: int
    """Its place among the samples of its socket, from 1."""
    where: str
    """File and line."""
    nominal: Point
    calibrated: Point
    weight: float | None = None
    """Robust weight in the fit, where there was one."""

    def of(self, model: ModelName) -> Point:
        """Return the deviation by one model [m]."""
        return self.nominal if model == "nominal" else self.calibrated

    def error(self, model: ModelName = "calibrated") -> float:
        """Return the length of the deviation by one model [m]."""
        return math.hypot(*self.of(model))


class CrossPlacement(Document, kw_only=True, frozen=True):
    """Errors everywhere after training on one placement alone, the paper's Fig. 6."""

    method: str
    names: tuple[str, ...]
    matrix: tuple[tuple[float, ...] | None, ...]
    """[i][j]: MAE on placement j after training on i [m]; None where i cannot be fitted alone."""


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


class PlotCaption(Document, kw_only=True, frozen=True):
    """A plot of the page, in one sentence."""

    id: str
    section: str
    title: str
    sentence: str


class ReportProvenance(Provenance, kw_only=True, frozen=True):
    """What the calibration was made from and with."""

    settings: dict[str, Any]
    """The options of ``mukca solve``."""


class ReportDocument(Document, kw_only=True, frozen=True):
    """All of ``report.json``."""

    format: str
    robot: str
    """As it was named to ``mukca solve``."""
    method: str
    optimizer: str
    iterations: int
    robot_name: str
    """As the URDF names it."""
    summary: RoleSummaries
    placements: tuple[PlacementReport, ...]
    between: tuple[KnownDistanceErrors, ...]
    tolerance: float
    """The error that the user's task allows [m]."""
    limits: Limits
    samples: tuple[SampleErrors, ...]
    """Thinned out where there are many; all other figures rest on all of them."""
    history: tuple[Iteration, ...]
    cross_placement: CrossPlacement | None
    """None with a single placement."""
    coverage: Coverage
    parameters: tuple[ParameterValue, ...]
    checks: tuple[Finding, ...] | None = None
    choices: tuple[str, ...] | None = None
    coefficients: tuple[Coefficient, ...] | None = None
    groups: tuple[PriorWidth, ...] | None = None
    log_evidence: float | None = None
    next_placement: NextPlacement | None = None
    noise: NoiseScale | None = None
    uncertainty: Uncertainty | None = None
    warnings: tuple[str, ...]
    provenance: ReportProvenance
    command: str
    """What makes the calibration again."""
    verdict: Verdict
    answers: Answers
    arm: ArmDrawing
    plots: tuple[PlotCaption, ...]


def read_report(file: Path) -> ReportDocument:
    """Read a ``report.json``.

    Raises:
        DocumentError: Missing, of another format, or damaged; the line names the key.
    """
    return read(file, ReportDocument, FORMAT)
