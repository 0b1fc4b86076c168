"""A plot of a page: its panels, and the one sentence that says what they show here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ....solver.assessment import ModelName, short_names
from ....solver.results import Role
from ..figures import PlotCaption, ReportDocument, lines
from .figure import Panel

MODELS: tuple[ModelName, ModelName] = ("nominal", "calibrated")
COLOURS = 6
"""Marks ``model-0``, ... that the style sheet has; more models or arms take them again."""


@dataclass(frozen=True)
class Plot:
    """One plot of a page."""

    caption: PlotCaption
    legend: tuple[tuple[str, str], ...]
    """Class of the mark, and its words."""
    panels: tuple[Panel, ...]
    layout: str
    """Class of the style sheet that lays out the panels."""
    scene: str
    """Name of a view that the page's script draws instead of panels."""
    controls: Mapping[str, object] = field(default_factory=dict[str, object])
    """Values that the template needs for the plot's controls."""


Maker = Callable[[ReportDocument], Plot | None]
"""Draws a plot from a report's figures; None where they hold nothing to draw."""


def plot(
    name: str,
    *panels: Panel,
    layout: str = "",
    scene: str = "",
    controls: Mapping[str, object] | None = None,
    **values: object,
) -> Plot:
    """Return a plot whose caption is a block of the captions, written with these values.

    A caption is a title; lines of the legend, ``- mark: words; mark: words``; and a sentence.
    """
    title, *rest = lines("captions.txt.j2", name.replace("-", "_"), **values)
    marks = [mark for line in rest if line.startswith("- ") for mark in line[2:].split("; ")]
    legend = tuple((mark, words) for mark, _, words in (one.partition(": ") for one in marks))
    sentence = " ".join(line for line in rest if not line.startswith("- "))
    caption = PlotCaption(id=name, title=title, sentence=sentence)
    return Plot(caption, legend, panels, layout, scene, controls or {})


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
