"""The plots of a report, by section: a new one is a function in this folder and a line here."""

from ..figures import ReportDocument
from . import fit, model, samples, workspace
from .figure import Maker, Plot

SECTIONS: tuple[tuple[str, tuple[Maker, ...]], ...] = (
    ("Three questions", (samples.table_map,)),
    ("Where the arms stand", (workspace.arms_together,)),
    (
        "Where the error is",
        (
            samples.errors_by_placement,
            samples.shares,
            samples.errors_in_3d,
            samples.errors_in_2d,
            fit.known_distances,
            fit.predicted_and_found,
            workspace.error_map,
            model.joints,
        ),
    ),
    ("The data", (samples.order, model.coverage, fit.cross_placement)),
    (
        "The fit and the model",
        (fit.history, workspace.arm_in_3d, model.parameters, model.error_curves, model.groups),
    ),
)
"""The page shows the map of the first section with the answers."""


def plots_of(report: ReportDocument) -> dict[str, list[Plot]]:
    """Return the plots that the figures allow, by section."""
    return {
        title: [plot for maker in makers if (plot := maker(report)) is not None]
        for title, makers in SECTIONS
    }
