"""Picture of the rests in a log."""

from collections.abc import Sequence

import numpy as np

from ..report.plots import Axis, Panel, named_rows
from .log import Log
from .rests import Rest

COLUMNS = 1000
"""A curve goes through the least and the largest value of each."""
SOCKETS = 4
"""Sockets with a colour of their own."""
STYLE = """
svg { background: white; font: 12px sans-serif; }
.end { text-anchor: end; }
.middle { text-anchor: middle; }
.grid { stroke: #ddd; }
.curve { fill: none; stroke: #222; }
rect { fill-opacity: .35; }
.none { fill: #999; }
.socket-0 { fill: #3b6fb6; }
.socket-1 { fill: #d9822b; }
.socket-2 { fill: #4f9a5b; }
.socket-3 { fill: #8a5bb0; }
"""


def rests_picture(log: Log, names: Sequence[str], rests: Sequence[Rest]) -> bytes:
    """Return the picture as SVG.

    A lane for each joint; a band for each rest, in the color of its socket, grey where it is no
    sample. Parts of the log, such as episodes, stand one behind the other.
    """
    times = log.stamps - log.stamps[0]
    begins = np.flatnonzero(np.diff(log.parts)) + 1
    for i in begins:  # a second passes between two parts
        times[i:] += times[i - 1] + 1.0 - times[i]
    duration = max(float(times[-1]), 1e-9)
    axis = Axis(0, duration, "s")
    panel = named_rows("rests of the arm", names, axis, pitch=48, width=1200)
    for number, pause in enumerate(rests, start=1):
        _band(panel, number, pause, float(times[pause.last]))
    for lane, positions in enumerate(log.positions.T):
        _curve(panel, lane, times, positions)
    return panel.file(STYLE)


def _band(panel: Panel, number: int, pause: Rest, end: float) -> None:
    """Draw a rest that ends at some time [s]."""
    begin = end - (pause.end - pause.begin)
    x = panel.x(begin)
    width = max(2.0, panel.x(end) - x)
    height = panel.bottom - panel.top
    colour = "none"
    if pause.placement is not None:
        colour = f"socket-{pause.socket % SOCKETS}"
    panel.add("rect", x=x, y=panel.top, width=width, height=height, class_=colour)
    panel.text(x, panel.top - 6, str(number), colour)


def _curve(
    panel: Panel,
    lane: int,
    times: np.ndarray,
    positions: np.ndarray,
) -> None:
    """Draw a joint's positions over the times, both (N,), over the height of its lane."""
    extent = max(np.ptp(positions), 1e-9)
    shares = (positions - positions.min()) / extent
    heights = lane + 0.42 - 0.84 * shares
    count = min(COLUMNS, len(times))
    begins = [moment[0] for moment in np.array_split(times, count)]
    columns = np.array_split(heights, count)
    ends = [(column.max(), column.min()) for column in columns]
    points = np.column_stack([np.repeat(begins, 2), np.ravel(ends)])
    panel.line(points.tolist(), "curve")
