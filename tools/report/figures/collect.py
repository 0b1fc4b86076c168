"""All figures of a report, worked out from a calibration: the way into this folder."""

from ....solver.assessment import DRAWN, Options, assess, distance_text, sample_errors, setting
from ....solver.results import CalibrationDocument, FitResult, fields_of
from .answers import answers_of
from .arm import arm_drawing
from .commands import solve_command
from .cross_placement import cross_placement
from .recommendations import steps
from .types import REPORT, ReportDocument, ReportProvenance


def report_figures(document: CalibrationDocument, source: str, options: Options) -> ReportDocument:
    """Return the figures of a report, without plots; errors as of :func:`.build.build_report`."""
    found = assess(document, source, options)
    predictions, placements = found.predictions, found.placements
    samples = sample_errors(predictions, DRAWN)
    matrix = cross_placement(predictions, setting(document, source, "regularization"))
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
        distance_text=distance_text(document.placements),
        provenance=ReportProvenance(**fields_of(document.provenance), settings=document.settings),
        command=solve_command(document),
        verdict=found.verdict,
        rests_on=found.verdict.rests_on,
        todo=steps(predictions, placements, found.verdict),
        answers=answers_of(found, samples, options.tolerance),
        arm=arm_drawing(predictions),
        plots=(),
    )
