"""All of ``report.json``: every number and sentence that its page shows.

Lengths are metres, angles radians. Points are in the robot's base frame: x ahead, y to the left.
"""

from pathlib import Path
from typing import Any, Literal

from ....solver import assessment
from ....solver.results import Document, FitResult, Provenance, read

REPORT = "mukca-report-1"
Answer = Literal["yes", "mostly", "no", "trained on"]
"""``mostly``: 19 of 20 samples; ``trained on``: its errors prove nothing."""


class Step(Document, kw_only=False):
    """One thing to do next."""

    text: str
    command: str
    expected: str = ""
    """Its benefit, in words."""
    before: float | None = None
    """The error before and after the step [m]; None where it lowers none."""
    after: float | None = None


class UseAtPlacement(Document):
    """May the arm be used for the task at this placement?"""

    name: str
    called: str
    """Its name, with the robot's side where it is on one."""
    where: str
    answer: Answer
    """With the report's ``tolerance``."""
    least: float | None = None
    """Least error that a task may allow for a yes [m]; None where it was trained on."""


class UseAnswer(Document):
    """The answer to "May I use this arm for my task?"."""

    rows: tuple[UseAtPlacement, ...]
    text: str
    meaning: str
    """Definition of the error."""
    alone: str | None
    """Error of the exported URDF by itself, where it is not the full model."""
    between: str
    """Accuracy of points that were not taught at the place itself."""
    cannot_see: tuple[str, ...]
    """Quantities that a ball in a socket cannot tell."""


class NextAnswer(Document):
    """The answer to "Which placement next?"."""

    text: str
    train_on: str | None
    """A placement that is recorded already, and worth training on too."""
    place: assessment.Point
    """Position at which to record a new one [m]."""
    joints: tuple[str, ...]
    """Those that hardly moved."""


class WorstSample(Document):
    """A sample far from its socket."""

    where: str
    """File and line."""
    name: str
    socket: int
    number: int
    """Its place among the samples of its socket, from 1."""
    weight: float | None
    """Robust weight in the fit; None where there was none."""
    error: float
    """Distance from its socket's centre by the calibrated model [m]."""
    ratio: float
    """That distance over the mean of its placement."""


class LoneFit(Document):
    """Error of a placement when fitted alone, the figure of ``mukca check``."""

    name: str
    mean_absolute_error: float
    """Mean distance of its samples from their socket, each by its weight [m]."""


class DataAnswer(Document):
    """The answer to "Is my data all right?"."""

    text: str
    worst: tuple[WorstSample, ...]
    floors: tuple[LoneFit, ...]


class Answers(Document):
    """The answers to the three questions that a user has."""

    use: UseAnswer
    next: NextAnswer
    data: DataAnswer


class Displacement(Document):
    """Distance between the balls of two models [m]."""

    mean: float
    max: float


class LinkMesh(Document):
    """The shape of one link."""

    frame: int
    """That it moves with: 0 for the base, i + 1 for the child link of joint i."""
    vertices: list[list[float]]
    """In that frame, shape (V, 3) [m]."""
    faces: list[list[int]]
    """Triangles by vertex, shape (F, 3)."""


class ArmDrawing(Document):
    """The arm in its recorded configurations, by both models."""

    joints: tuple[str, ...]
    placements: list[int]
    """Of each configuration, the index."""
    nominal: list[list[list[float]]]
    """Places of the joints, shape (configurations, joints + 1, 3) [m]: base first, ball last."""
    calibrated: list[list[list[float]]]
    low: assessment.Point
    """Corner of what the calibrated arm fills [m]."""
    high: assessment.Point
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


class CrossPlacement(Document):
    """Errors everywhere after training on one placement alone, the paper's Fig. 6."""

    method: str
    names: tuple[str, ...]
    matrix: tuple[tuple[float, ...] | None, ...]
    """[i][j]: MAE on placement j after training on i [m]; None where i cannot be fitted alone."""


class PlotCaption(Document):
    """A plot of a page, in short sentences."""

    id: str
    title: str
    sentence: str
    section: str = ""


class ReportProvenance(Provenance):
    """Origin of the calibration: its data, programs and options."""

    settings: dict[str, Any]


class ReportDocument(FitResult):
    """All of ``report.json``."""

    format: str
    robot_name: str
    """As the URDF names it."""
    summary: assessment.RoleSummaries
    placements: tuple[assessment.PlacementReport, ...]
    between: tuple[assessment.KnownDistanceErrors, ...]
    task: float | None = None
    """The error that the user's task allows [m]; None where nobody said."""
    tolerance: float
    """Error for which shares and answers hold [m]: that of the task, or 0.5 mm."""
    limits: assessment.Limits
    samples: tuple[assessment.SampleErrors, ...]
    """Thinned out where there are many; all other figures rest on all of them."""
    cross_placement: CrossPlacement | None
    """None with a single placement."""
    coverage: assessment.Coverage
    distance_text: str = ""
    """The distances between sockets that were used, and the source of each."""
    provenance: ReportProvenance
    command: str
    """Command that makes the calibration again."""
    verdict: assessment.Verdict
    rests_on: tuple[assessment.Premise, ...]
    """Of the verdict: what no recording can tell."""
    todo: tuple[Step, ...] = ()
    """Steps to do next, the most useful first; empty where the verdict is PASS."""
    answers: Answers
    arm: ArmDrawing
    plots: tuple[PlotCaption, ...]

    @property
    def full_model(self) -> str:
        """Name of the full model; it is calibrated.urdf itself where that holds all."""
        alone = self.summary.judged[1].geometric is None
        return "calibrated.urdf" if alone else "the full model"


def read_report(file: Path) -> ReportDocument:
    """Read a ``report.json``; a DocumentError names the key that is missing or damaged."""
    return read(file, ReportDocument, REPORT)
