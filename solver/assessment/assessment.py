"""A calibration held against its limits: all that a verdict rests on."""

from dataclasses import dataclass

from ..results import CalibrationDocument
from .coverage import Coverage, coverage
from .data_sufficiency import rows_of_the_fit
from .errors import PlacementReport, RoleSummaries, placement_reports, role_summaries
from .held_out import between_row, held_out_rows
from .known_distances import KnownDistanceErrors, known_distance_errors
from .limits import Limits, Options, limits_of
from .predictions import Predictions, predict
from .scale_check import rests_on
from .verdict import Verdict, judge

DRAWN = 3000
"""Samples drawn at most; all figures are computed from all of them."""


@dataclass(frozen=True)
class Assessment:
    """A calibration, its verdict, and the figures that lead to it."""

    predictions: Predictions
    limits: Limits
    between: tuple[KnownDistanceErrors, ...]
    summary: RoleSummaries
    placements: tuple[PlacementReport, ...]
    coverage: Coverage
    verdict: Verdict


def assess(document: CalibrationDocument, source: str, options: Options) -> Assessment:
    """Return the verdict on a calibration.

    Args:
        document: The calibration.
        source: Its file, for messages.
        options: Limits, known distances, the task's tolerance.

    Raises:
        DocumentError: Parts of the document do not fit each other; the line names the key.
        MeasurementError: Its samples cannot be used.
        KnownError: A known distance names no socket of the calibration.
    """
    predictions = predict(document, source)
    limits = limits_of(document, source, options)
    between = known_distance_errors(predictions, options.known)
    summary = role_summaries(predictions, options.tolerance)
    placements = placement_reports(predictions, options.tolerance)
    covered = coverage(predictions, DRAWN)
    held_out = held_out_rows(predictions, limits)
    rows = [
        *held_out,
        between_row(between, limits.between_placements),
        *rows_of_the_fit(predictions, covered, limits, held_out),
    ]
    verdict = judge(rows, rests_on(document), document.hypotheses or ())
    return Assessment(predictions, limits, between, summary, placements, covered, verdict)
