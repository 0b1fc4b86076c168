"""The report of a calibration as one page."""

from collections.abc import Mapping, Sequence

from ....solver.results import encode
from ..figures import ReportDocument
from ..plots import Maker, Plot, cell, fit, model, outlook, samples, scenes, use
from .details import details
from .frames import frames
from .html import Element, tag
from .html.frame import frame
from .sections import answers, headline, limits_table, placements_table, todo, verdict_box
from .tolerance import answers_by_tolerance

PLOTS: tuple[tuple[str, tuple[Maker, ...]], ...] = (
    ("Three questions", (use.table_map,)),
    ("Where the arms stand", (cell.arms_together,)),
    (
        "Where the error is",
        (
            use.errors_by_placement,
            use.shares,
            scenes.errors_in_3d,
            samples.errors_in_2d,
            fit.known_distances,
            fit.predicted_and_found,
            outlook.error_map,
            outlook.joints,
        ),
    ),
    ("The data", (samples.order, model.coverage, fit.cross_placement)),
    (
        "The fit and the model",
        (fit.history, scenes.arm_in_3d, model.parameters, model.groups),
    ),
)
"""The plots by section; the map of the first stands with the answers."""


def plots_of(report: ReportDocument) -> dict[str, list[Plot]]:
    """Return the plots that the figures allow, by section."""
    return {
        title: [plot for maker in makers if (plot := maker(report)) is not None]
        for title, makers in PLOTS
    }


def page(report: ReportDocument, plots: Mapping[str, Sequence[Plot]]) -> str:
    """Return the report as HTML.

    Args:
        report: The figures.
        plots: As :func:`plots_of` returns them.
    """
    (_, (table_map,)), *sections = plots.items()
    body = [
        headline(report),
        verdict_box(report),
        todo(report),
        limits_table(report),
        answers(report, table_map.element()),
        placements_table(report),
        frames(report),
        _which_model(report),
        *(
            tag("section", tag("h2", title), [plot.element() for plot in group], class_="plots")
            for title, group in sections
            if group
        ),
        details(report),
    ]
    data = {
        "figures": encode(report, compact=True),
        "by-tolerance": encode(answers_by_tolerance(report), compact=True),
    }
    return frame(f"Calibration of {report.robot_name}", body, data)


def _which_model(report: ReportDocument) -> Element | None:
    """Return which model the plots call calibrated, where there are two."""
    _, judged = report.summary.judged
    if judged.geometric is None:
        return None
    return tag(
        "p",
        "In the plots below, calibrated is the full model, which corrects joint positions first. "
        "What calibrated.urdf alone reaches stands in the tables above.",
    )
