"""The plots of a report, by section: a new one is a function in this folder and a line here."""

from ..figures import ReportDocument
from . import arms, fit, joint_coverage, model, patterns, places, samples, workspace
from .figure import Maker, Plot

SECTIONS: tuple[tuple[str, tuple[Maker, ...]], ...] = (
    ("Answer", (places.errors_by_placement,)),
    ("Three questions", (places.table_map,)),
    ("Where the arms stand", (arms.arms_together,)),
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
    ("Where the rest sits", (patterns.patterns,)),
    ("The data", (samples.order, joint_coverage.coverage)),
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
        made = [maker(report) for maker in makers]
        plots[title] = [plot for plot in made if plot is not None]
    return plots
