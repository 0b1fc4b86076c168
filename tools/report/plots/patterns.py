"""Plots of the errors that the fit leaves, over joints' angles, reach, height and time."""

import math

import numpy as np

from ....solver.results import ErrorPattern
from ..figures import ReportDocument
from .axis import Axis
from .figure import Panel, Plot, plot

_UNITS = {"rad": (math.degrees(1), "degrees"), "m": (1e3, "mm"), "": (100.0, "% of a placement")}


def patterns(report: ReportDocument) -> Plot | None:
    """Each sample's error over each quantity, the running mean, and its band."""
    if report.error_patterns is None:
        return None
    rows = sorted(report.error_patterns.patterns, key=lambda pattern: -pattern.log_odds)
    errors = sorted(abs(1e3 * error) for row in rows for error in row.errors)
    half = errors[int(0.99 * (len(errors) - 1))]
    panels = [_panel(row, Axis.around_zero([half], "mm")) for row in rows]
    text = report.error_patterns.text
    return plot("patterns", *panels, layout="thirds", text=text, first=rows[0].over)


def _panel(row: ErrorPattern, y: Axis) -> Panel:
    """Return the errors of one pattern, the band about zero, and the running mean."""
    factor, unit = _UNITS[row.unit]
    low = factor * row.grid[0]
    high = factor * row.grid[-1]
    x = Axis(low, max(high, low + 1e-6), unit)
    panel = Panel(f"{row.over}: {row.along}", x, y, width=248, height=190, margin=44).grid()
    grid = [factor * value for value in row.grid]
    band = 1e3 * np.array(row.band)
    panel.area(grid, -band, band, "deviation-area")
    panel.rule("zero", y=0)
    places = zip(row.at, row.errors, strict=True)
    marks = [(panel.x(factor * value), panel.y(1e3 * error)) for value, error in places]
    # One path for all samples, since a page of a thousand circles is slow.
    squares = "".join(f"M{a - 1:.1f} {b - 1:.1f}h2v2h-2z" for a, b in marks)
    panel.add("path", d=squares, class_="calibrated")
    means = [1e3 * mean for mean in row.mean]
    panel.line(zip(grid, means, strict=True), "running")
    return panel
