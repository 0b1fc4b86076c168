"""A calibration held against its limits: all that a verdict rests on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..data import KnownDistance
from ..results import CalibrationDocument, misfit
from .coverage import Coverage, coverage
from .data_sufficiency import prediction_row, samples_row, travel_row
from .errors import PlacementReport, RoleSummaries, placement_reports, role_summaries
from .known_distances import KnownDistanceErrors, known_distance_errors
from .limits import LimitResult, Limits, limits_for
from .predictions import Predictions, predict
from .scale_check import scale_row
from .verdict import Verdict, judge

DRAWN = 3000
"""Samples drawn at most; all figures are computed from all of them."""


@dataclass(frozen=True)
class Options:
    """Limits and known distances, as far as the user gives them."""

    repeatability: float | None = None
    """Of the arm [m]; None for what is known of it."""
    mean_absolute_error: float | None = None
    """Limit [m]; None, here and below, for a multiple of the repeatability."""
    distance_error: float | None = None
    between_placements: float | None = None
    known: Sequence[KnownDistance] = ()
    tolerance: float = 5e-4
    """The error that the user's task allows [m]."""


def setting(document: CalibrationDocument, source: str, key: str) -> float | None:
    """Return a number that was given to ``mukca solve``, if any.

    Raises:
        DocumentError: It is no number.
    """
    value = document.settings.get(key)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise misfit(source, f"settings.{key}", f"{value!r} is no number")
    return float(value)


def limits_of(document: CalibrationDocument, source: str, options: Options) -> Limits:
    """Return what a calibration is held against; arguments as for :func:`judged`."""
    given = setting(document, source, "repeatability_mm")
    return limits_for(
        document.model,
        options.repeatability or (None if given is None else given / 1e3),
        mean_absolute_error=options.mean_absolute_error,
        distance_error=options.distance_error,
        between_placements=options.between_placements,
        servos=bool(document.settings.get("zeros")),
    )


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
    held_out = [p.measured.kind for p in predictions.placements if p.role == "test"]
    verdict = judge(
        summary.test,
        between,
        document.checks,
        limits,
        _sufficiency(predictions, covered, limits),
        by_instrument=bool(held_out) and set(held_out) == {"points"},
    )
    return Assessment(predictions, limits, between, summary, placements, covered, verdict)


def _sufficiency(
    predictions: Predictions, covered: Coverage, limits: Limits
) -> tuple[LimitResult, ...]:
    """Return the rows on the arm's size, and on the amount of the data."""
    document = predictions.document
    rows = [
        samples_row(predictions.placements, tied=bool(document.settings.get("known"))),
        travel_row(covered),
    ]
    if document.scale is not None:
        rows.insert(0, scale_row(document.scale, document.placements, document.checks))
    limit = limits.mean_absolute_error
    rows.append(
        prediction_row(document.uncertainty, limit, document.method, covered, document.scale)
    )
    return tuple(rows)
