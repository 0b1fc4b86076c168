"""Plot of what moved while recording: the positions of each joint, and how far it moved."""

import math
from itertools import product
from typing import NamedTuple

import numpy as np

from ....solver.assessment import Coverage, short_names
from ..figures import HARDLY_MOVED, ReportDocument
from .axis import MM, Axis
from .figure import Plot, named_rows, plot
from .panel import Panel

_PITCH = 34
"""Height of a joint's row, in the panel's units."""


class _Unit(NamedTuple):
    """A unit in which positions are shown."""

    si: str
    name: str
    factor: float
    """From the SI unit."""


_DEGREES = _Unit("rad", "degrees", math.degrees(1))
_UNITS = (_DEGREES, _Unit("m", "mm", MM))


def coverage(report: ReportDocument) -> Plot:
    """Positions of each joint in each socket, within its limits, and how far it turned."""
    covered = report.coverage
    panels: list[Panel] = []
    for unit in _UNITS:
        joints = [i for i, joint in enumerate(covered.joints) if joint.unit == unit.si]
        if joints:
            panels.append(_positions(covered, joints, unit))
            panels.append(_spans(covered, joints, unit))
    return plot(
        "coverage",
        *panels,
        spans=_turns(covered),
        limit=math.degrees(HARDLY_MOVED),
    )


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


def _positions(covered: Coverage, joints: list[int], unit: _Unit) -> Panel:
    """Return a tick for each position, and the joints' limits."""
    rows = [covered.joints[i] for i in joints]
    limits = np.array(
        [(row.lower, row.upper) for row in rows], dtype=float
    )  # NaN: none
    ends = np.array([(socket.low, socket.high) for socket in covered.sockets])
    every_end = np.append(limits, ends[:, :, joints])
    low = float(np.nanmin(every_end))
    high = float(np.nanmax(every_end))
    high = max(high, low + 1e-6 / unit.factor)
    title = f"positions, {unit.name}; socket 0 above, others below"
    names = [row.name for row in rows]
    axis = Axis(low, high, unit.name, unit.factor)
    panel = named_rows(title, names, axis, pitch=_PITCH)
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


def _spans(covered: Coverage, joints: list[int], unit: _Unit) -> Panel:
    """Return a dot for each joint and socket, and the least that a joint should turn."""
    names = [covered.joints[i].name for i in joints]
    highs = np.array([socket.high for socket in covered.sockets])
    lows = np.array([socket.low for socket in covered.sockets])
    spans = (highs - lows)[:, joints]
    axis = Axis.from_zero(spans.ravel(), unit.name, unit.factor)
    title = f"how far it moved in each socket, {unit.name}"
    panel = named_rows(title, names, axis, pitch=_PITCH)
    for row, spans_of_joint in enumerate(spans.T.tolist()):
        for socket, span in zip(covered.sockets, spans_of_joint, strict=True):
            shown = f"{unit.factor * span:.0f} {unit.name}"
            hint = f"{socket.placement}, socket {socket.socket}: {shown}"
            panel.dot(span, row, f"span-dot {socket.role}", hint, size=4)
    if unit == _DEGREES:
        panel.threshold("at least {} degrees", x=HARDLY_MOVED)
    return panel
