"""All figures of a report, worked out from a calibration: the way into this folder."""

from ....solver.assessment import (
    DRAWN,
    Options,
    distance_text,
    judged,
    sample_errors,
    setting,
)
from ....solver.diagnostics import fitted_alone
from ....solver.results import CalibrationDocument, FitResult, fields_of
from .answer_data import data_answer
from .answers import next_answer, use_answer
from .arm import arm_drawing
from .commands import solve_command
from .cross_placement import cross_placement
from .recommendations import steps
from .types import REPORT, ReportDocument, ReportProvenance
from .types_answers import Answers


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
    found = judged(document, source, options)
    predictions, placements, covered = found.predictions, found.placements, found.coverage
    verdict, limits, tolerance = found.verdict, found.limits, options.tolerance
    samples = sample_errors(predictions, DRAWN)
    matrix = cross_placement(predictions, setting(document, source, "regularization"))
    seated = [p.measured for p in predictions.placements if p.measured.kind == "sockets"]
    floors = fitted_alone(predictions.robot, seated)
    answers = Answers(
        use=use_answer(placements, found.summary, verdict, limits, document.uncertainty, tolerance),
        next=next_answer(placements, covered, document.checks, document.next_placement),
        data=data_answer(placements, samples, floors, document.checks),
    )
    return ReportDocument(
        **{name: getattr(document, name) for name in FitResult.__struct_fields__},
        format=REPORT,
        robot_name=predictions.robot.name,
        summary=found.summary,
        placements=placements,
        between=found.between,
        tolerance=tolerance,
        limits=limits,
        samples=samples,
        cross_placement=matrix,
        coverage=covered,
        distance_text=distance_text(document.placements),
        provenance=ReportProvenance(**fields_of(document.provenance), settings=document.settings),
        command=solve_command(document),
        verdict=verdict,
        todo=steps(predictions, placements, verdict),
        answers=answers,
        arm=arm_drawing(predictions),
        plots=(),
    )
