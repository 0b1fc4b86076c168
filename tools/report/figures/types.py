"""All of ``report.json`` and ``compare.json``: every number and sentence that their pages show.

Lengths are metres, angles radians. Points are in the robot's base frame: x ahead, y to the left.
"""

from pathlib import Path
from typing import Any

from ....solver.assessment import (
    Coverage,
    KnownDistanceErrors,
    Limits,
    PlacementReport,
    Quantiles,
    RoleSummaries,
    SampleErrors,
    Verdict,
)
from ....solver.results import Document, FitResult, Provenance, read
from .types_answers import Answers, Step
from .types_drawing import ArmDrawing, CrossPlacement, Displacement

REPORT = "mukca-report-1"
COMPARISON = "mukca-comparison-1"


class PlotCaption(Document, kw_only=True, frozen=True):
    """A plot of a page, in one sentence."""

    id: str
    title: str
    sentence: str


class ReportPlot(PlotCaption, kw_only=True, frozen=True):
    """A plot of the report's page."""

    section: str


class ReportProvenance(Provenance, kw_only=True, frozen=True):
    """Origin of the calibration: its data, programs and options."""

    settings: dict[str, Any]
    """The options of ``mukca solve``."""


class ReportDocument(FitResult, kw_only=True, frozen=True):
    """All of ``report.json``."""

    format: str
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
    cross_placement: CrossPlacement | None
    """None with a single placement."""
    coverage: Coverage
    distance_text: str = ""
    """The distances between sockets that were used, and the source of each."""
    provenance: ReportProvenance
    command: str
    """Command that makes the calibration again."""
    verdict: Verdict
    todo: tuple[Step, ...] = ()
    """Steps to do next, the most useful first; empty where the verdict is PASS."""
    answers: Answers
    arm: ArmDrawing
    plots: tuple[ReportPlot, ...]


def read_report(file: Path) -> ReportDocument:
    """Read a ``report.json``.

    Raises:
        DocumentError: Missing, of another format, or damaged; the line names the key.
    """
    return read(file, ReportDocument, REPORT)


class ErrorsOverall(Quantiles, kw_only=True, frozen=True):
    """A model's errors over all placements that none of the models was trained on."""

    mean_absolute_error: float
    distance_error: float | None
    """Mean of the absolute values; None where no placement has two sockets."""


class ComparedModel(Document, kw_only=True, frozen=True):
    """One of the models: the nominal one, or a calibration."""

    name: str
    summary: ErrorsOverall | None
    """None where every placement was trained on by some model."""


class ErrorsAtPlacement(Document, kw_only=True, frozen=True):
    """A model's errors at one placement."""

    mean_absolute_error: float
    max_error: float
    distance_error: float | None
    """Predicted less measured; None where there is one socket only."""
    quantiles: Quantiles
    trained_on: bool


class ComparedPlacement(Document, kw_only=True, frozen=True):
    """One placement, and the errors of all models there."""

    name: str
    samples: tuple[int, ...]
    """Number of samples in each socket."""
    models: tuple[ErrorsAtPlacement, ...]


class Difference(Document, kw_only=True, frozen=True):
    """By how much the error of one model exceeds that of another."""

    mean: float
    noise: float
    """Half the width of the mean's 95 % interval."""
    beyond_noise: bool


class ComparedPair(Document, kw_only=True, frozen=True):
    """Model b less model a."""

    a: int
    """Index of the model."""
    b: int
    placements: tuple[Difference, ...]
    summary: Difference | None
    """Over the placements that none of the models was trained on; None where there are none."""
    apart: Displacement
    """Of the ball between the two, after a rigid motion of the base frame is taken out."""


class ComparisonDocument(Document, kw_only=True, frozen=True):
    """All of ``compare.json``."""

    format: str
    robot_name: str
    models: tuple[ComparedModel, ...]
    """The nominal model first."""
    placements: tuple[ComparedPlacement, ...]
    fair: tuple[int, ...]
    """Indices of the placements that none of the models was trained on."""
    pairs: tuple[ComparedPair, ...]
    """Each model less each one before it in the list."""
    plots: tuple[PlotCaption, ...] | None = None
    """Only where a page was written."""
