"""A plot of the report: what it shows, and the one sentence that says what that means here."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ....solver.assessment import ModelName, short_names
from ....solver.results.calibration import Role
from ..figures import ReportDocument
from ..page.html import Element, tag

MODELS: tuple[ModelName, ModelName] = ("nominal", "calibrated")
BOTH = tuple((model, model) for model in MODELS)
"""The two models' marks in a legend."""


@dataclass(frozen=True)
class Plot:
    """One plot."""

    id: str
    title: str
    sentence: str
    panels: tuple[Element, ...]
    legend: tuple[tuple[str, str], ...] = field(default=())
    """Class of the mark, and its words."""
    class_: str = ""
    """How the panels are laid out."""

    def element(self) -> Element:
        """Return the plot as it stands in the page."""
        return tag(
            "figure",
            tag("h3", self.title),
            legend(self.legend) if self.legend else None,
            tag("div", self.panels, class_=f"panels {self.class_}".strip()),
            tag("figcaption", self.sentence),
            id=self.id,
            class_=f"plot {self.class_}".strip(),
        )


Maker = Callable[[ReportDocument], Plot | None]
"""Draws a plot from a report's figures; None where they hold nothing to draw."""


def legend(entries: tuple[tuple[str, str], ...]) -> Element:
    """Return what the marks mean."""
    return tag(
        "p",
        [tag("span", tag("i", class_=f"key {mark}"), words) for mark, words in entries],
        class_="legend",
    )


def judged_role(report: ReportDocument) -> tuple[Role, str]:
    """Return the role that verdicts rest on, and what to call it."""
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
