"""A picture of a log: each joint over time, and the rests that were found in it."""

from collections.abc import Sequence

import numpy as np

from ..report.plots import Axis, named_rows
from .log import Log
from .rests import Proposal

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


def rests_picture(log: Log, names: Sequence[str], proposals: Sequence[Proposal]) -> bytes:
    """Return the picture as SVG.

    A lane for each joint; a band for each rest, in the color of its socket, grey where it is no
    sample. Parts of the log, such as episodes, stand one behind the other.
    """
    times = log.stamps - log.stamps[0]
    for i in np.flatnonzero(np.diff(log.parts)) + 1:  # a second passes between two parts
        times[i:] += times[i - 1] + 1.0 - times[i]
    axis = Axis(0, max(float(times[-1]), 1e-9), "s")
    panel = named_rows("rests of the arm", names, axis, pitch=48, width=1200)
    for number, proposal in enumerate(proposals, start=1):
        rest = proposal.timed
        end = _moment(log, times, rest.end, rest.rest.position)
        x = panel.x(end - (rest.end - rest.begin))
        size = {"width": max(2.0, panel.x(end) - x), "height": panel.bottom - panel.top}
        colour = "none" if proposal.placement is None else f"socket-{proposal.socket % SOCKETS}"
        panel.add("rect", x=x, y=panel.top, **size, class_=colour)
        panel.text(x, panel.top - 6, str(number), colour)
    blocks = np.array_split(np.arange(len(times)), min(COLUMNS, len(times)))
    for lane, values in enumerate(log.positions.T):
        low, size = values.min(), max(np.ptp(values), 1e-9)
        heights = lane + 0.42 - 0.84 * (values - low) / size
        ends = [(b, end) for b in blocks for end in (heights[b].max(), heights[b].min())]
        panel.line([(float(times[b[0]]), float(end)) for b, end in ends], "curve")
    return panel.file(STYLE)


def _moment(log: Log, times: np.ndarray, stamp: float, position: Sequence[float]) -> float:
    """Return the time of a stamp; of equal ones, that at which the arm stood there."""
    off = np.abs(log.stamps - stamp)
    nearest = np.flatnonzero(off <= off.min() + 1e-9)
    there = np.abs(log.positions[nearest] - np.array(position)).max(axis=1)
    return float(times[nearest[np.argmin(there)]])
