"""A calibration held against its limits: all that a verdict rests on."""

from dataclasses import dataclass

from ..results import CalibrationDocument
from .coverage import Coverage, coverage
from .data_sufficiency import checks_row, prediction_row, samples_row, travel_row
from .errors import PlacementReport, RoleSummaries, placement_reports, role_summaries
from .held_out import between_row, held_out_rows
from .known_distances import KnownDistanceErrors, known_distance_errors
from .limits import LimitResult, Limits, Options, limits_of
from .predictions import Predictions, predict
from .scale_check import assumed_distances, distance_row, distortion_row, rests_on, scale_row
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
    kinds = [p.measured.kind for p in predictions.placements if p.role == "test"]
    by_instrument = bool(kinds) and set(kinds) == {"points"}
    rows = [
        *held_out_rows(summary.test, limits, by_instrument=by_instrument),
        between_row(between, limits.between_placements),
        *_rows_of_the_fit(predictions, covered, limits),
    ]
    verdict = judge(rows, rests_on(document))
    return Assessment(predictions, limits, between, summary, placements, covered, verdict)


def _rows_of_the_fit(
    predictions: Predictions, covered: Coverage, limits: Limits
) -> list[LimitResult]:
    """Return the rows on the recordings, the arm's size, and the amount of the data."""
    document = predictions.document
    rows = [
        checks_row(document.checks),
        distortion_row(document),
        distance_row(assumed_distances(document)),
    ]
    if document.scale is not None:
        rows.append(scale_row(document.scale, document.placements, document.checks))
    limit = limits.mean_absolute_error
    return [
        *rows,
        samples_row(predictions.placements, tied=bool(document.settings.get("known"))),
        travel_row(covered),
        prediction_row(document.uncertainty, limit, document.method, covered, document.scale),
    ]
