"""All figures of a report, worked out from a calibration, and the cross-placement matrix."""

from dataclasses import replace

from ....errors import MukcaError
from ....solver import assessment
from ....solver.data import evaluate
from ....solver.paper import REGULARIZATION, Problem, build_problem, solve
from ....solver.results import CalibrationDocument, FitResult, fields_of
from ....solver.robot import all_parameters
from .answers import answers_of
from .arm import arm_drawing
from .recommendations import solve_command, steps
from .types import REPORT, CrossPlacement, ReportDocument, ReportProvenance


def report_figures(
    document: CalibrationDocument, source: str, options: assessment.Options
) -> ReportDocument:
    """Return the figures of a report, without plots; errors as of :func:`.build.build_report`."""
    found = assessment.assess(document, source, options)
    predictions, placements = found.predictions, found.placements
    samples = assessment.sample_errors(predictions, assessment.DRAWN)
    matrix = cross_placement(predictions, assessment.setting(document, source, "regularization"))
    return ReportDocument(
        **{name: getattr(document, name) for name in FitResult.__struct_fields__},
        format=REPORT,
        robot_name=predictions.robot.name,
        summary=found.summary,
        placements=placements,
        between=found.between,
        tolerance=options.tolerance,
        limits=found.limits,
        samples=samples,
        cross_placement=matrix,
        coverage=found.coverage,
        distance_text=assessment.distance_text(document.placements),
        provenance=ReportProvenance(**fields_of(document.provenance), settings=document.settings),
        command=solve_command(document),
        verdict=found.verdict,
        rests_on=found.verdict.rests_on,
        todo=steps(predictions, placements, found.verdict),
        answers=answers_of(found, samples, options.tolerance),
        arm=arm_drawing(predictions),
        plots=(),
    )


def cross_placement(
    predictions: assessment.Predictions, regularization: float | None
) -> CrossPlacement | None:
    """Return the errors everywhere by models trained on each placement alone; None for only one."""
    if len(predictions.placements) < 2:
        return None
    # By Eq. (5), some 10 ms each, with the joint origins that the calibration itself had free.
    chosen = {parameter.name for parameter in predictions.calibration.parameters}
    problem = build_problem(
        predictions.robot,
        [placement.measured for placement in predictions.placements],
        parameters=[p for p in all_parameters(predictions.robot) if p.name in chosen],
        regularization=REGULARIZATION if regularization is None else regularization,
    )
    return CrossPlacement(
        method="Eq. (5)",
        names=tuple(placement.name for placement in predictions.placements),
        matrix=tuple(_row(problem, placement) for placement in predictions.placements),
    )


def _row(problem: Problem, trained_on: assessment.PlacementPrediction) -> tuple[float, ...] | None:
    if not trained_on.measured.has_distance:
        return None
    try:
        x = solve(replace(problem, training=(trained_on.measured,))).x
    except MukcaError:
        return None
    return tuple(
        evaluate(problem.model.points(x, m.positions), m).mean_absolute_error
        for m in problem.training
    )
