"""Plots over joints: the positions recorded, how far each moved, and the errors that stay."""

import math
from itertools import product

import numpy as np

from ....solver.assessment import Coverage, short_names
from ....solver.results import ErrorPattern
from ..figures import HARDLY_MOVED, ReportDocument
from .axis import MM, Axis
from .figure import Plot, named_rows, plot
from .panel import Panel

_PITCH = 34
"""Height of a joint's row, in the panel's units."""


_UNITS = {
    "rad": (math.degrees(1), "degrees"),
    "m": (MM, "mm"),
    "": (100.0, "% of a placement"),
}
"""Factors from SI units, and names of the units that are shown."""
_SHOWN = 0.99
"""Share of the samples whose errors are within the vertical axis, at least."""


def coverage(report: ReportDocument) -> Plot:
    """Positions of each joint in each socket, within its limits, and how far it turned."""
    covered = report.coverage
    panels: list[Panel] = []
    for unit in ("rad", "m"):
        joints = [i for i, joint in enumerate(covered.joints) if joint.unit == unit]
        if joints:
            panels.append(_positions(covered, joints, unit))
            panels.append(_spans(covered, joints, unit))
    limit = math.degrees(HARDLY_MOVED)
    return plot("coverage", *panels, spans=_turns(covered), limit=limit)


def _turns(covered: Coverage) -> list[tuple[float, str, int, str]]:
    """Return how far each joint turned in each socket [degrees], with their names."""
    places = short_names([socket.placement for socket in covered.sockets])
    turns: list[tuple[float, str, int, str]] = []
    for i, joint in enumerate(covered.joints):
        if joint.unit != "rad":
            continue
        for socket, place in zip(covered.sockets, places, strict=True):
            turn = math.degrees(socket.high[i] - socket.low[i])
            turns.append((turn, joint.name, socket.socket, place))
    return turns


def _positions(covered: Coverage, joints: list[int], unit: str) -> Panel:
    """Return a tick for each position, and the joints' limits."""
    factor, words = _UNITS[unit]
    rows = [covered.joints[i] for i in joints]
    limits = np.array([(r.lower, r.upper) for r in rows], dtype=float)  # NaN: none
    ends = np.array([(socket.low, socket.high) for socket in covered.sockets])
    every_end = np.append(limits, ends[:, :, joints])
    low = float(np.nanmin(every_end))
    high = float(np.nanmax(every_end))
    high = max(high, low + 1e-6 / factor)
    title = f"positions, {words}; socket 0 above, others below"
    names = [row.name for row in rows]
    panel = named_rows(title, names, Axis(low, high, words, factor), pitch=_PITCH)
    panel.bars(limits[:, 0], limits[:, 1], "range", thick=26)
    for (row, joint), role in product(enumerate(joints), ("test", "train")):
        marks = ""
        for socket in covered.sockets:
            if socket.role == role:
                top = panel.y(row) + (1 if socket.socket else -12)
                for q in socket.positions:
                    marks += f"M{panel.x(q[joint]):.1f} {top}v11"
        if marks:
            panel.add("path", d=marks, class_=f"tick-{role}")
    return panel


def _spans(covered: Coverage, joints: list[int], unit: str) -> Panel:
    """Return a dot for each joint and socket, and the least that a joint should turn."""
    factor, words = _UNITS[unit]
    names = [covered.joints[i].name for i in joints]
    highs = np.array([socket.high for socket in covered.sockets])
    lows = np.array([socket.low for socket in covered.sockets])
    spans = (highs - lows)[:, joints]
    axis = Axis.from_zero(spans.ravel(), words, factor)
    title = f"how far it moved in each socket, {words}"
    panel = named_rows(title, names, axis, pitch=_PITCH)
    for row, spans_of_joint in enumerate(spans.T.tolist()):
        for socket, span in zip(covered.sockets, spans_of_joint, strict=True):
            where = f"{socket.placement}, socket {socket.socket}"
            hint = f"{where}: {factor * span:.0f} {words}"
            panel.dot(
                span,
                row,
                f"span-dot {socket.role}",
                hint,
                size=4,
            )
    if unit == "rad":
        panel.threshold("at least {} degrees", x=HARDLY_MOVED)
    return panel


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
    panels = [_pattern_panel(row, y) for row in rows]
    first = rows[0].over
    return plot(
        "patterns",
        *panels,
        layout="thirds",
        text=evidence.text,
        first=first,
    )


def _pattern_panel(row: ErrorPattern, y: Axis) -> Panel:
    """Return the errors of one pattern, the band about zero, and the running mean."""
    factor, unit = _UNITS[row.unit]
    low = row.grid[0]
    high = max(row.grid[-1], low + 1e-6 / factor)
    title = f"{row.over}: {row.along}"
    x = Axis(low, high, unit, factor)
    panel = Panel(title, x, y, width=248, height=190, margin=44).grid()
    band = np.array(row.band)
    panel.area(row.grid, -band, band, "deviation-area")
    panel.rule("zero", y=0)
    # One path for all samples, since a page of a thousand circles is slow.
    squares = ""
    for value, error in zip(row.at, row.errors, strict=True):
        squares += f"M{panel.x(value) - 1:.1f} {panel.y(error) - 1:.1f}h2v2h-2z"
    panel.add("path", d=squares, class_="calibrated")
    panel.line(zip(row.grid, row.mean, strict=True), "running")
    return panel
