"""A plot of the report: what it shows, and the one sentence that says what that means here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .markup import Element, tag
from .words import short_names

__all__ = ["BOTH", "Figures", "Maker", "Plot", "judged_role", "legend", "lengths", "names_of"]

Figures = Mapping[str, Any]
BOTH = (("nominal", "nominal"), ("calibrated", "calibrated"))
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


Maker = Callable[[Figures], Plot | None]
"""Draws a plot from a report's figures; None where they hold nothing to draw."""


def legend(entries: tuple[tuple[str, str], ...]) -> Element:
    """Return what the marks mean."""
    return tag(
        "p",
        [tag("span", tag("i", class_=f"key {mark}"), words) for mark, words in entries],
        class_="legend",
    )


def judged_role(figures: Figures) -> tuple[str, str]:
    """Return the role that figures rest on, and what to call it."""
    return ("test", "held-out") if figures["summary"]["test"] else ("train", "trained-on")


def names_of(figures: Figures) -> list[str]:
    """Return the placements' names, as short as they can be."""
    return short_names([row["name"] for row in figures["placements"]])


def lengths(figures: Figures, model: str, role: str | None = None) -> Any:
    """Return the error of each sample [m], of one role or of all, shape (N,)."""
    found = [
        float(np.linalg.norm(row[model]))
        for row in figures["samples"]
        if role is None or figures["placements"][row["placement"]]["role"] == role
    ]
    return np.array(found)
