"""Plots of the errors that the fit leaves, over joints' angles, reach, height and time."""

import math

import numpy as np

from ....solver.results import ErrorPattern
from ..figures import ReportDocument
from .axis import MM, Axis
from .figure import Panel, Plot, plot

_UNITS = {
    "rad": (math.degrees(1), "degrees"),
    "m": (MM, "mm"),
    "": (100.0, "% of a placement"),
}


def patterns(report: ReportDocument) -> Plot | None:
    """Each sample's error over each quantity, the running mean, and its band."""
    if report.error_patterns is None:
        return None
    rows = sorted(report.error_patterns.patterns, key=lambda pattern: -pattern.log_odds)
    errors = np.sort(np.abs(np.concatenate([row.errors for row in rows])))
    nearly_all = errors[int(0.99 * (len(errors) - 1))]
    y = Axis.around_zero([nearly_all], "mm", MM)
    return plot(
        "patterns",
        *(_panel(row, y) for row in rows),
        layout="thirds",
        text=report.error_patterns.text,
        first=rows[0].over,
    )


def _panel(row: ErrorPattern, y: Axis) -> Panel:
    """Return the errors of one pattern, the band about zero, and the running mean."""
    factor, unit = _UNITS[row.unit]
    low = row.grid[0]
    x = Axis(low, max(row.grid[-1], low + 1e-6 / factor), unit, factor)
    panel = Panel(
        f"{row.over}: {row.along}", x, y, width=248, height=190, margin=44
    ).grid()
    band = np.array(row.band)
    panel.area(row.grid, -band, band, "deviation-area")
    panel.rule("zero", y=0)
    # One path for all samples, since a page of a thousand circles is slow.
    centres = zip(map(panel.x, row.at), map(panel.y, row.errors), strict=True)
    squares = "".join(f"M{x - 1:.1f} {y - 1:.1f}h2v2h-2z" for x, y in centres)
    panel.add("path", d=squares, class_="calibrated")
    panel.line(zip(row.grid, row.mean, strict=True), "running")
    return panel
