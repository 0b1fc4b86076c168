"""A plot of the report: what it shows, and the one sentence that says what that means here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .markup import Element, tag

__all__ = ["Figures", "Maker", "Plot", "legend"]

Figures = Mapping[str, Any]


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

    def element(self) -> Element:
        """Return the plot as it stands in the page."""
        return tag(
            "figure",
            tag("h3", self.title),
            legend(self.legend) if self.legend else None,
            tag("div", self.panels, class_=f"panels {self.class_}".strip()),
            tag("figcaption", self.sentence),
            id=self.id,
            class_="plot",
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
