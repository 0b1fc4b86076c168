"""What ``report.json`` holds: every number and sentence that the report's page shows.

Lengths are metres, angles radians. Points are in the robot's base frame: x ahead, y to the left.
"""

from pathlib import Path
from typing import Any

from ....solver.assessment import (
    Coverage,
    KnownDistanceErrors,
    Limits,
    PlacementReport,
    RoleSummaries,
    SampleErrors,
    Verdict,
)
from ....solver.diagnostics import Diagnostic
from ....solver.results import (
    ArmsDocument,
    Document,
    FramePose,
    NextPlacement,
    Outlook,
    Provenance,
    read,
)
from ....solver.results.calibration import (
    Coefficient,
    Iteration,
    NoiseScale,
    ParameterValue,
    PriorWidth,
    Scale,
    Uncertainty,
)
from .types_answers import Answers, Step
from .types_drawing import ArmDrawing, CrossPlacement

FORMAT = "mukca-report-1"


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
    checks: tuple[Diagnostic, ...] | None = None
    choices: tuple[str, ...] | None = None
    coefficients: tuple[Coefficient, ...] | None = None
    groups: tuple[PriorWidth, ...] | None = None
    log_evidence: float | None = None
    scale: Scale | None = None
    frames: tuple[FramePose, ...] | None = None
    arm_name: str = ""
    """Where several robots were calibrated together, the name of this one."""
    arms: ArmsDocument | None = None
    """What it has in common with the others."""
    distance_text: str = ""
    """The distances between sockets that were used, and where each is from."""
    next_placement: NextPlacement | None = None
    noise: NoiseScale | None = None
    uncertainty: Uncertainty | None = None
    outlook: Outlook | None = None
    warnings: tuple[str, ...]
    provenance: ReportProvenance
    command: str
    """What makes the calibration again."""
    verdict: Verdict
    todo: tuple[Step, ...] = ()
    """What to do next, the most useful first; empty where the verdict is PASS."""
    answers: Answers
    arm: ArmDrawing
    plots: tuple[PlotCaption, ...]


def read_report(file: Path) -> ReportDocument:
    """Read a ``report.json``.

    Raises:
        DocumentError: Missing, of another format, or damaged; the line names the key.
    """
    return read(file, ReportDocument, FORMAT)
