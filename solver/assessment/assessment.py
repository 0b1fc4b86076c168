"""The assessment of a calibration by its limits: when it is made, and on later recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

from msgspec import structs

from ..diagnostics import Survey, inspect_all
from ..identification.data import Measurement
from ..results import CalibratedRobot, CalibrationDocument, Summary
from .conclusion import Verdict, conclude
from .data_sufficiency import checks_row, rows_of_the_fit
from .errors import (
    KnownDistanceErrors,
    PlacementReport,
    RoleSummaries,
    known_distance_errors,
    placement_reports,
    role_summaries,
)
from .held_out import (
    between_row,
    error_rows,
    held_out_rows,
    measured_errors,
    worse_in_words,
)
from .limits import LimitResult, Limits, Options, limits_of
from .predictions import Coverage, Predictions, coverage, predict
from .scale_check import rests_on

FEW = 15
"""With fewer samples in a socket its mean is too uncertain for a limit on means of many."""
TOLERANCE = 5e-4
"""Error within which samples are counted where nobody said what the task allows [m]."""
TRAINED = (
    "the calibration was made from these samples, so their errors prove nothing; "
    "give placements that solve has not seen"
)


@dataclass(frozen=True)
class Assessment:
    """A calibration, its verdict, and the figures that lead to it."""

    predictions: Predictions
    task: float | None
    """The error that the user's task allows [m]; None where nobody said."""
    tolerance: float
    """Error within which samples are counted [m]."""
    limits: Limits
    between: tuple[KnownDistanceErrors, ...]
    summary: RoleSummaries
    placements: tuple[PlacementReport, ...]
    coverage: Coverage
    verdict: Verdict


def assess(document: CalibrationDocument, source: str, options: Options) -> Assessment:
    """Return the verdict on a calibration, whose file messages name by ``source``.

    Raises:
        DocumentError: Parts of the document do not fit each other; the line names the key.
        MeasurementError: Its samples cannot be used.
        KnownError: A known distance names no socket of the calibration.
    """
    predictions = predict(document, source)
    limits = limits_of(document, source, options)
    between = known_distance_errors(predictions, options.known)
    covered = coverage(predictions)
    held_out = held_out_rows(predictions, limits)
    rows = [
        *held_out,
        between_row(between, limits.between_placements),
        *rows_of_the_fit(predictions, covered, limits, held_out),
    ]
    causes, proved = document.hypotheses or (), held_out[0].found is not None
    held_out_summary = document.summary.proof if proved else None
    verdict = conclude(
        rows,
        document.better,
        held_out_summary,
        rests_on(document),
        causes,
        measured_errors(predictions),
        worse_in_words(document),
    )
    tolerance = TOLERANCE if options.task is None else options.task
    figures = (
        limits,
        between,
        role_summaries(predictions, tolerance),
        placement_reports(predictions, tolerance),
        covered,
        verdict,
    )
    return Assessment(predictions, options.task, tolerance, *figures)


def rows_since(
    calibrated: CalibratedRobot,
    new: Summary | None,
    data: Sequence[Measurement],
    limits: Limits,
    *,
    zeros: bool,
    compared: bool,
) -> tuple[list[LimitResult], Survey]:
    """Return the rows of a verdict on samples recorded later, and what was seen in them.

    ``new`` are the errors of ``data``, None where all were trained on. Where explanations were
    ``compared`` by their evidence, few samples, or an arm of unknown limits, need not keep limits.
    """
    corrected = None if new is None or new.geometric is None else new.calibrated
    rows = error_rows(None if new is None else new.loaded, corrected, limits, TRAINED)
    if new is not None:
        rows = rows if new.loaded.distance_error is not None else rows[:1]
        rows = [row for row in rows if not compared or row.limit is not None]
        few = compared and min(chain.from_iterable(m.counts for m in data)) < FEW
        for i, row in enumerate(rows if few else ()):
            if row.status == "fail":
                text = f"{row.text}, by a few samples"
                rows[i] = structs.replace(row, status="warning", text=text)
    robot = calibrated.robot.with_origins(calibrated.origins)
    survey = inspect_all(robot, data, zeros=zeros, repeatability=limits.repeatability)
    return [*rows, checks_row(survey.diagnostics)], survey
