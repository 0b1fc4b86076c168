"""All figures of a report, worked out from a calibration: the way into this folder."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ....solver.checks.inspection import fitted_alone
from ....solver.data.known import KnownDistance
from ...documents.calibration import CalibrationDocument, misfit
from ...documents.files import fields_of
from ...documents.report import FORMAT, ReportDocument, ReportProvenance
from ...documents.report_drawing import Coverage
from ...documents.report_verdict import Answers, LimitResult, Limits
from .acceptance import limits_for
from .answers.data import data_answer
from .answers.next import next_answer
from .answers.use import use_answer
from .arm import arm_drawing
from .commands import solve_command
from .coverage import coverage
from .cross_placement import cross_placement
from .earned import prediction_row, samples_row, travel_row
from .errors import placement_reports, role_summaries, sample_errors
from .known_distances import known_distance_errors
from .predictions import Predictions, predict
from .size import distance_text, scale_row
from .todo import steps
from .verdict import judge

__all__ = ["Options", "limits_of", "report_figures"]

DRAWN = 3000
"""Samples drawn at most; all figures are computed from all of them."""


@dataclass(frozen=True)
class Options:
    """What the user may choose about a report."""

    repeatability: float | None = None
    """Of the arm [m]; None for what is known of it."""
    mean_absolute_error: float | None = None
    """Limit [m]; None, here and below, for a multiple of the repeatability."""
    distance_error: float | None = None
    between_placements: float | None = None
    known: Sequence[KnownDistance] = ()
    tolerance: float = 5e-4
    """The error that the user's task allows [m]."""


def _setting(document: CalibrationDocument, source: str, key: str) -> float | None:
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
    """Return what a calibration is held against; arguments as for :func:`report_figures`."""
    given = _setting(document, source, "repeatability_mm")
    return limits_for(
        document.model,
        options.repeatability or (None if given is None else given / 1e3),
        mean_absolute_error=options.mean_absolute_error,
        distance_error=options.distance_error,
        between_placements=options.between_placements,
        servos=bool(document.settings.get("zeros")),
    )


def report_figures(document: CalibrationDocument, source: str, options: Options) -> ReportDocument:
    """Return the figures of a report, without plots.

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
    regularization = _setting(document, source, "regularization")
    tolerance = options.tolerance
    limits = limits_of(document, source, options)
    between = known_distance_errors(predictions, options.known)
    summary = role_summaries(predictions, tolerance)
    placements = placement_reports(predictions, tolerance)
    samples = sample_errors(predictions, DRAWN)
    matrix = cross_placement(predictions, regularization)
    seated = [p.measured for p in predictions.placements if p.measured.kind == "sockets"]
    floors = fitted_alone(predictions.robot, seated)
    covered = coverage(predictions, DRAWN)
    earned = _earned(predictions, covered, limits)
    held_out = [p.measured.kind for p in predictions.placements if p.role == "test"]
    verdict = judge(
        summary.test,
        between,
        document.checks,
        limits,
        earned,
        by_instrument=bool(held_out) and set(held_out) == {"points"},
    )
    answers = Answers(
        use=use_answer(placements, summary, verdict, limits, document.uncertainty, tolerance),
        next=next_answer(placements, covered, document.checks, document.next_placement),
        data=data_answer(placements, samples, floors, document.checks),
    )
    return ReportDocument(
        format=FORMAT,
        robot=document.robot,
        method=document.method,
        optimizer=document.optimizer,
        iterations=document.iterations,
        robot_name=predictions.robot.name,
        summary=summary,
        placements=placements,
        between=between,
        tolerance=tolerance,
        limits=limits,
        samples=samples,
        history=document.history,
        cross_placement=matrix,
        coverage=covered,
        parameters=document.parameters,
        checks=document.checks,
        choices=document.choices,
        coefficients=document.coefficients,
        groups=document.groups,
        log_evidence=document.log_evidence,
        scale=document.scale,
        frames=document.frames,
        arm_name=document.arm_name,
        arms=document.arms,
        distance_text=distance_text(document.placements),
        next_placement=document.next_placement,
        noise=document.noise,
        uncertainty=document.uncertainty,
        outlook=document.outlook,
        warnings=document.warnings,
        provenance=ReportProvenance(**fields_of(document.provenance), settings=document.settings),
        command=solve_command(document),
        verdict=verdict,
        todo=steps(predictions, placements, verdict),
        answers=answers,
        arm=arm_drawing(predictions),
        plots=(),
    )


def _earned(predictions: Predictions, covered: Coverage, limits: Limits) -> tuple[LimitResult, ...]:
    """Return what else a verdict rests on: the arm's size, and how much was recorded."""
    document = predictions.document
    rows = [
        samples_row(predictions.placements, tied=bool(document.settings.get("known"))),
        travel_row(covered),
    ]
    if document.scale is not None:
        rows.insert(0, scale_row(document.scale, document.placements, document.checks))
    limit = limits.mean_absolute_error
    rows.append(prediction_row(document.uncertainty, limit, document.method, covered))
    return tuple(rows)
