"""A plot of a page: its panels, and the one sentence that says what they show here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ....solver.assessment import ModelName, short_names
from ....solver.results import Role
from ..figures import ReportDocument
from .figure import Panel

MODELS: tuple[ModelName, ModelName] = ("nominal", "calibrated")
BOTH = tuple((model, model) for model in MODELS)
"""The two models' marks in a legend."""
HOLLOW = ("hollow", "hollow: trained on")
COLOURS = 6
"""Marks ``model-0``, ... that the style sheet has; more models or arms take them again."""


@dataclass(frozen=True)
class Plot:
    """One plot of a page."""

    id: str
    title: str
    sentence: str
    panels: tuple[Panel, ...] = ()
    legend: tuple[tuple[str, str], ...] = ()
    """Class of the mark, and its words."""
    layout: str = ""
    """Class of the style sheet that lays out the panels."""
    scene: str = ""
    """Name of a view that the page's script draws instead of panels."""
    controls: Mapping[str, object] = field(default_factory=dict[str, object])
    """Values that the template needs for the plot's controls."""


Maker = Callable[[ReportDocument], Plot | None]
"""Draws a plot from a report's figures; None where they hold nothing to draw."""


def judged_role(report: ReportDocument) -> tuple[Role, str]:
    """Return the role that verdicts rest on, and its name."""
    role, _ = report.summary.judged
    return role, "held-out" if role == "test" else "trained-on"


def names_of(report: ReportDocument) -> list[str]:
    """Return the placements' names, as short as they can be."""
    return short_names([row.name for row in report.placements])


def lengths(report: ReportDocument, model: ModelName, role: Role | None = None) -> np.ndarray:
    """Return the error of each sample [m], of one role or of all, shape (N,)."""
    return np.array(
        [
            row.error(model)
            for row in report.samples
            if role is None or report.placements[row.placement].role == role
        ]
    )
