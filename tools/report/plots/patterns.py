"""Plots of the errors that the fit leaves, over joints' angles, reach, height and time."""

import math

import numpy as np

from ....solver.results import ErrorPattern
from ..figures import ReportDocument
from .axis import MM, Axis
from .figure import Plot, plot
from .panel import Panel

_UNITS = {
    "rad": (math.degrees(1), "degrees"),
    "m": (MM, "mm"),
    "": (100.0, "% of a placement"),
}
_SHOWN = 0.99
"""Share of the samples whose errors are within the vertical axis, at least."""


def patterns(report: ReportDocument) -> Plot | None:
    """Each sample's error over each quantity, the running mean, and its band."""
    evidence = report.error_patterns
    if evidence is None:
        return None
    rows = sorted(evidence.patterns, key=lambda pattern: -pattern.log_odds)
    errors = np.concatenate([row.errors for row in rows])
    sizes = np.sort(np.abs(errors))
    nearly_all = sizes[int(_SHOWN * (len(sizes) - 1))]
    y = Axis.around_zero([nearly_all], "mm", MM)
    panels = [_panel(row, y) for row in rows]
    return plot(
        "patterns",
        *panels,
        layout="thirds",
        text=evidence.text,
        first=rows[0].over,
    )


def _panel(row: ErrorPattern, y: Axis) -> Panel:
    """Return the errors of one pattern, the band about zero, and the running mean."""
    factor, unit = _UNITS[row.unit]
    low = row.grid[0]
    high = max(row.grid[-1], low + 1e-6 / factor)
    panel = Panel(
        f"{row.over}: {row.along}",
        Axis(low, high, unit, factor),
        y,
        width=248,
        height=190,
        margin=44,
    ).grid()
    band = np.array(row.band)
    panel.area(row.grid, -band, band, "deviation-area")
    panel.rule("zero", y=0)
    # One path for all samples, since a page of a thousand circles is slow.
    squares = ""
    for value, error in zip(row.at, row.errors, strict=True):
        corner = panel.x(value) - 1
        top = panel.y(error) - 1
        squares += f"M{corner:.1f} {top:.1f}h2v2h-2z"
    panel.add("path", d=squares, class_="calibrated")
    means = zip(row.grid, row.mean, strict=True)
    panel.line(means, "running")
    return panel
