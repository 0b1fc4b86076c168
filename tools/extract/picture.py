"""A picture of a log: each joint over time, and the rests that were found in it."""

from collections.abc import Sequence
from xml.sax.saxutils import escape

import numpy as np

from .log import Log
from .socket_assignment import Proposal

WIDTH, LANE, LEFT, TOP = 1200, 48, 150, 40
COLUMNS = 1000
COLORS = ("#3b6fb6", "#d9822b", "#4f9a5b", "#8a5bb0")
NONE = "#b8b8b8"


def rests_picture(log: Log, names: Sequence[str], proposals: Sequence[Proposal]) -> bytes:
    """Return the picture as SVG.

    A lane for each joint; a band for each rest, in the color of its socket, grey where it is no
    sample. Parts of the log, such as episodes, stand one behind the other.

    Args:
        log: The joint states.
        names: Of the joints, in chain order.
        proposals: The rests, in order.
    """
    times = _one_behind_the_other(log)
    scale = (WIDTH - LEFT - 10) / max(float(times[-1] - times[0]), 1e-9)

    def x(moment: float) -> float:
        return LEFT + (moment - float(times[0])) * scale

    height = TOP + LANE * len(names) + 24
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
        'font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for number, proposal in enumerate(proposals, start=1):
        rest = proposal.timed
        end = x(_moment(log, times, rest.end, rest.rest.position))
        width = max(2.0, (rest.end - rest.begin) * scale)
        socket = proposal.socket % len(COLORS)
        color = NONE if proposal.placement is None else COLORS[socket]
        parts.append(
            f'<rect x="{end - width:.1f}" y="{TOP}" width="{width:.1f}" '
            f'height="{LANE * len(names)}" fill="{color}" opacity="0.35"/>'
            f'<text x="{end - width:.1f}" y="{TOP - 6}" fill="{color}">{number}</text>'
        )
    for lane, name in enumerate(names):
        bottom = TOP + LANE * (lane + 1)
        parts.append(f'<text x="8" y="{bottom - LANE / 2:.0f}">{escape(name)}</text>')
        parts.append(_curve(times, log.positions[:, lane], x, bottom))
    parts.append(f'<text x="{LEFT}" y="{height - 8}">{times[-1] - times[0]:.0f} s</text></svg>\n')
    return "\n".join(parts).encode()


def _one_behind_the_other(log: Log) -> np.ndarray:
    """Return times that never go back: a second passes between two parts."""
    times = log.stamps.copy()
    for i in np.flatnonzero(np.diff(log.parts)) + 1:
        times[i:] += times[i - 1] + 1.0 - times[i]
    return times


def _moment(log: Log, times: np.ndarray, stamp: float, position: Sequence[float]) -> float:
    """Return the time of a stamp; of equal ones, that at which the arm stood there."""
    off = np.abs(log.stamps - stamp)
    nearest = np.flatnonzero(off <= off.min() + 1e-9)
    there = np.abs(log.positions[nearest] - np.array(position)).max(axis=1)
    return float(times[nearest[np.argmin(there)]])


def _curve(times: np.ndarray, values: np.ndarray, x: object, bottom: int) -> str:
    """Return a line that goes through the least and largest value of each column of pixels."""
    assert callable(x)
    low, high = float(values.min()), float(values.max())
    size = max(high - low, 1e-9)
    points: list[str] = []
    for block in np.array_split(np.arange(len(values)), min(COLUMNS, len(values))):
        for value in (values[block].min(), values[block].max()):
            y = bottom - 4 - (LANE - 8) * (float(value) - low) / size
            points.append(f"{x(float(times[block[0]])):.1f},{y:.1f}")
    return f'<polyline points="{" ".join(points)}" fill="none" stroke="#222" stroke-width="1"/>'
