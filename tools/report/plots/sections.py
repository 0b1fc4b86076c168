"""The plots of a report by section, and those of its answers: errors by placement, and the map.

A new plot is a function in this folder, and a line in its section here.
"""

from collections.abc import Sequence

from ....solver.assessment import area
from ..figures import Answer, ReportDocument, text
from . import coverage, fit, model, samples, workspace
from .axis import MM, Axis
from .figure import (
    FROM_ABOVE,
    LOADED,
    Maker,
    Plot,
    from_above,
    named_rows,
    plot,
    to_scale,
)
from .panel import Panel

MARGIN = 0.16
"""Of the map [m]."""
SPOT = 10
"""Radius of a placement on the map, in the panel's units."""


def errors_by_placement(report: ReportDocument) -> Plot:
    """Mean absolute error before and after at each placement, and the limit."""
    names = [row.name for row in report.answers.use.rows]
    roles = [row.role for row in report.placements]
    before = [row.before.mean_absolute_error for row in report.placements]
    after = [row.loaded.mean_absolute_error for row in report.placements]
    x = Axis.logarithmic([*before, *after], "mean absolute error, mm", MM)
    panel = named_rows("error at each placement", names, x, pitch=28)
    panel.bars(before, after, "link")
    for (_, mark), values in zip(LOADED, (before, after), strict=True):
        panel.dots(values, [f"{mark} {role}" for role in roles], mark)
    panel.threshold("limit {} mm", x=report.limits.mean_absolute_error.value)
    judged_role, _ = report.summary.judged
    columns = zip(after, before, names, roles, strict=True)
    return plot(
        "errors-by-placement",
        panel,
        layout="half",
        report=report,
        judged=[row for row in columns if row[-1] == judged_role],
    )


def table_map(report: ReportDocument) -> Plot:
    """The placements as the robot sees them from above, coloured by the answer for the task."""
    place = report.answers.next.place
    positions = [row.position for row in report.placements]
    points = from_above([(0, 0, 0), place, *positions])
    panel = to_scale("", points, FROM_ABOVE, room=MARGIN)
    (x, y), following, *spots = points.tolist()
    panel.dot(x, y, "base", "the robot's base", size=9)
    panel.text(panel.x(x) + 13, panel.y(y) + 4, "robot", "tick")
    x, y = following
    panel.dot(
        x,
        y,
        "next",
        f"record next: {area(place)}",
        size=9,
    )
    panel.text(panel.x(x), panel.y(y) + 22, "next", "tick middle")
    for i, spot in enumerate(spots):
        _draw_spot(panel, report, i, spot)
    uses = report.answers.use.rows
    asked = report.task is not None
    allowed = f"{MM * report.tolerance:g}" if asked else None
    return plot(
        "table-map",
        panel,
        layout="beside",
        controls={"uses": uses},
        text=map_sentence(report, [use.answer for use in uses], allowed),
        asked=asked,
    )


def _draw_spot(
    panel: Panel,
    report: ReportDocument,
    i: int,
    spot: Sequence[float],
) -> None:
    """Draw a placement at its place, with its number, in the colour of its answer."""
    use = report.answers.use.rows[i]
    word = "unasked"
    if report.task is not None or use.least is None:
        word = use.answer.split(" ")[0]
    x, y = panel.x(spot[0]), panel.y(spot[1])
    hint = f"{use.name}: {area(report.placements[i].position)}"
    panel.add(
        "circle",
        hint,
        cx=x,
        cy=y,
        r=SPOT,
        class_=f"answer {word}",
        data_placement=i,
    )
    panel.text(x, y + 4, str(i + 1), "number middle light")


def map_sentence(
    report: ReportDocument,
    answers: Sequence[Answer],
    allowed: str | None,
) -> str:
    """Return at how many places the task can be done, with the error that it allows in words."""
    heights = [row.position[2] for row in report.placements]
    role, _ = report.summary.judged
    return text(
        "map_sentence",
        role=role,
        total=sum(row.role == role for row in report.placements),
        allowed=allowed,
        proven=answers.count("yes"),
        low=min(heights),
        high=max(heights),
    )


SECTIONS: tuple[tuple[str, tuple[Maker, ...]], ...] = (
    ("Answer", (errors_by_placement,)),
    ("Three questions", (table_map,)),
    ("Where the arms stand", (workspace.arms_together,)),
    (
        "Where the error is",
        (
            samples.shares,
            fit.predicted_and_found,
            samples.errors_in_3d,
            samples.errors_in_2d,
            workspace.error_map,
            fit.cross_placement,
            model.joints,
            fit.known_distances,
            workspace.arm_in_3d,
        ),
    ),
    ("Where the rest sits", (coverage.patterns,)),
    ("The data", (samples.order, coverage.coverage)),
    (
        "The fit and the model",
        (fit.history, model.parameters, model.error_curves, model.groups),
    ),
)
"""The page shows the plot of the first section with the verdict, the next with the answers."""
FOLDED = (
    "predicted-found",
    *("errors-3d", "errors-2d", "error-map", "cross-placement", "joints", "arm-3d"),
    "patterns",
    *("order", "coverage"),
    *("history", "parameters", "curves", "groups"),
)
"""Plots that the page shows where somebody asks for them."""


def plots_of(report: ReportDocument) -> dict[str, list[Plot]]:
    """Return the plots that the figures allow, by section."""
    plots: dict[str, list[Plot]] = {}
    for title, makers in SECTIONS:
        plots[title] = [made for maker in makers if (made := maker(report))]
    return plots
