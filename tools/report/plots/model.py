"""Plots of the model: parameters, what moved while recording, groups, error curves of joints."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, product
from typing import NamedTuple

import numpy as np

from ....solver.assessment import Coverage, short_names
from ....solver.bayes.model.effects import ANGLES, EFFECTS, Display, effect_named
from ....solver.results import JointCurve
from ..figures import HARDLY_MOVED, ReportDocument
from .axis import MM, Axis
from .figure import Panel, Plot, named_rows, plot

_ORIGINS = {
    "m": Display("mm", 1e3, usual_turn=1.0, heading="joint origins, places"),
    "rad": replace(ANGLES, heading="joint origins, angles"),
}
"""Looks of the numbers of the geometry, by SI unit."""
_NOT_COUNTED = ("ball", "given")
"""Groups of the prior that the plot of groups leaves out."""
_DEGREES = math.degrees(1)
LEAST_BLANK = 10.0
"""Angles without samples that are named, all together [degrees]."""


def display_of(name: str, unit: str) -> Display:
    """Return the looks of a parameter, or of a group of them, by its name and SI unit."""
    effect = effect_named(name)
    return effect.display if effect else _ORIGINS.get(unit, Display(unit))


def parameters(report: ReportDocument) -> Plot:
    """Changes by the calibration, as bars, with standard deviations where there are any."""
    changes = [(row, row.change) for row in report.parameters]
    # the coefficients of effects that are switched off are zero for certain
    active = [
        row for row in report.coefficients or () if row.value or row.standard_deviation
    ]
    changes += [(row, row.value) for row in active]
    bars_by_axis: dict[tuple[str, str, float], list[_Bar]] = {}
    for row, change in changes:
        display = display_of(row.name, row.unit)
        # 0 where it is not known.
        deviation = display.factor * (row.standard_deviation or 0.0)
        bar = _Bar(row.name, display, display.factor * change, deviation)
        axis = display.heading, display.unit, display.per_mm
        bars_by_axis.setdefault(axis, []).append(bar)
    panels = list(bars_by_axis.values())
    determined = [bar for bar in chain(*panels) if bar.standard_deviation]
    repeatability = report.limits.repeatability
    usual_words = dict.fromkeys(
        effect.display.usual_words for effect in EFFECTS.values()
    )
    return plot(
        "parameters",
        *(_bars_panel(bars, MM * (repeatability or 0.0)) for bars in panels),
        report=report,
        usual=list(filter(None, usual_words)),
        largest=[max(bars, key=lambda bar: abs(bar.value)) for bars in panels],
        known=len(determined),
        clear=sum(abs(bar.value) > 2 * bar.standard_deviation for bar in determined),
    )


class _Bar(NamedTuple):
    """A change as it is drawn, in the unit of its display."""

    name: str
    display: Display
    value: float
    standard_deviation: float

    @property
    def label(self) -> str:
        """The name on the axis."""
        return self.name.rpartition(".")[0] if self.display.by_joint else self.name


def _bars_panel(bars: Sequence[_Bar], repeatability: float) -> Panel:
    """Return bars of one display, and the changes that move a ball by the repeatability [mm]."""
    display = bars[0].display
    unit = display.unit
    changes = np.array([bar.value for bar in bars])
    deviations = np.array([bar.standard_deviation for bar in bars])
    sizes = np.abs(changes)
    # Deviations of what no ball can show are far larger than any change; they are cut off.
    axis = Axis.around_zero(
        sizes + np.minimum(deviations, sizes.max()), unit, smallest=1e-6
    )
    names = [bar.label for bar in bars]
    panel = named_rows(f"{display.heading}, {unit}", names, axis, pitch=15)
    panel.rule("zero", x=0)
    panel.thresholds(f"{{}} {unit}", repeatability * display.per_mm)
    panel.bars(0, changes, "change", thick=8)
    panel.bars(changes - deviations, changes + deviations, "deviation")
    return panel


def coverage(report: ReportDocument) -> Plot:
    """Positions of each joint in each socket, within its limits, and how far it turned."""
    covered = report.coverage
    panels: list[Panel] = []
    for unit, factor, unit_name in (("rad", _DEGREES, "degrees"), ("m", MM, "mm")):
        joints_of_unit = [
            i for i, joint in enumerate(covered.joints) if joint.unit == unit
        ]
        if joints_of_unit:
            panels.append(_positions(covered, joints_of_unit, factor, unit_name))
            panels.append(_spans(covered, joints_of_unit, factor, unit_name))
    places = short_names([socket.placement for socket in covered.sockets])
    spans: list[tuple[float, str, int, str]] = []
    for i, joint in enumerate(covered.joints):
        for s, place in zip(covered.sockets, places, strict=True):
            if joint.unit == "rad":
                spans.append(
                    (_DEGREES * (s.high[i] - s.low[i]), joint.name, s.socket, place)
                )
    return plot("coverage", *panels, spans=spans, limit=HARDLY_MOVED * _DEGREES)


def _positions(
    covered: Coverage, joint_rows: Sequence[int], factor: float, unit: str
) -> Panel:
    """Return a tick for each position, and the joints' limits."""
    rows = [covered.joints[i] for i in joint_rows]
    # NaN: no limit.
    limits = np.array([(row.lower, row.upper) for row in rows], dtype=float)
    ends = np.array([(s.low, s.high) for s in covered.sockets])[:, :, joint_rows]
    every_end = np.concatenate([limits.ravel(), ends.ravel()])
    low = float(np.nanmin(every_end))
    high = float(np.nanmax(every_end))
    title = f"positions, {unit}; socket 0 above, others below"
    axis = Axis(low, max(high, low + 1e-6 / factor), unit, factor)
    panel = named_rows(title, [row.name for row in rows], axis, pitch=34)
    panel.bars(limits[:, 0], limits[:, 1], "range", thick=26)
    for (k, i), role in product(enumerate(joint_rows), ("test", "train")):
        marks = ""
        for s in covered.sockets:
            if s.role == role:
                y = panel.y(k) + (1 if s.socket else -12)
                marks += "".join(f"M{panel.x(q[i]):.1f} {y}v11" for q in s.positions)
        if marks:
            panel.add("path", d=marks, class_=f"tick-{role}")
    return panel


def _spans(
    covered: Coverage, joint_rows: Sequence[int], factor: float, unit: str
) -> Panel:
    """Return a dot for each joint and socket, and the least that a joint should turn."""
    names = [covered.joints[i].name for i in joint_rows]
    spans = np.array([np.subtract(s.high, s.low) for s in covered.sockets])[
        :, joint_rows
    ]
    axis = Axis.from_zero(spans.ravel(), unit, factor)
    panel = named_rows(
        f"how far it moved in each socket, {unit}", names, axis, pitch=34
    )
    for k, spans_of_joint in enumerate(spans.T.tolist()):
        for s, span in zip(covered.sockets, spans_of_joint, strict=True):
            hint = f"{s.placement}, socket {s.socket}: {factor * span:.0f} {unit}"
            panel.dot(span, k, f"span-dot {s.role}", hint, size=4)
    if unit == "degrees":
        panel.threshold("at least {} degrees", x=HARDLY_MOVED)
    return panel


def groups(report: ReportDocument) -> Plot | None:
    """Effective parameters of each group: those that the data determine, of all there are."""
    groups_of_fit = report.groups or ()
    rows = [row for row in groups_of_fit if row.name not in _NOT_COUNTED]
    if not rows:
        return None
    names = [row.name.replace("_", " ") for row in rows]
    axis = Axis(0, 100, "%")
    panel = named_rows("share of the group that the data settle", names, axis, pitch=28)
    shares = [100 * row.effective / max(row.count, 1) for row in rows]
    panel.bars(0, [100] * len(rows), "range", thick=16)
    panel.bars(0, shares, "change", thick=16)
    for i, (row, share) in enumerate(zip(rows, shares, strict=True)):
        words = f"{row.effective:.1f} of {row.count}" if row.active else "off"
        panel.text(panel.x(min(share, 62)) + 6, panel.y(i) + 4, words, "tick")
    named = list(zip(names, rows, strict=True))
    return plot(
        "groups",
        panel,
        layout="half",
        rows=rows,
        on=[name for name, row in named if row.active is True],
        off=[name for name, row in named if row.active is False],
        others=sum(row.count for row in groups_of_fit if row.name in _NOT_COUNTED),
    )


def joints(report: ReportDocument) -> Plot | None:
    """Displacement of the ball by each joint's calibrated numbers."""
    if report.outlook is None or not report.outlook.joints:
        return None
    rows = report.outlook.joints
    names = [row.joint for row in rows]
    recorded = [row.recorded for row in rows]
    anywhere = [row.workspace for row in rows]
    repeatability = report.limits.repeatability
    axis = Axis.from_zero([*recorded, *anywhere, repeatability], "mm", MM)
    panel = named_rows("what each joint moves the ball by, mm", names, axis)
    panel.bars(0, anywhere, "link", thick=14)
    panel.bars(0, recorded, "change", thick=7)
    panel.threshold("the arm repeats to {} mm", x=repeatability)
    ranked = sorted(((MM * row.recorded, row.joint) for row in rows), reverse=True)
    return plot(
        "joints",
        panel,
        layout="half",
        report=report,
        most=ranked[:2],
    )


def error_curves(report: ReportDocument) -> Plot | None:
    """Error curve of each joint, with a band of one standard deviation."""
    if report.curves is None or not report.curves.joints:
        return None
    curves = report.curves.joints
    ends = [np.abs(curve.values) + curve.deviations for curve in curves]
    y = Axis.around_zero([float(np.max(ends))], "mrad", ANGLES.factor)
    repeatability = report.limits.repeatability
    panels: list[Panel] = []
    blank: list[str] = []
    for curve in curves:
        angles = _angles(report.coverage, curve.joint)
        panels.append(_panel(curve, y, angles, repeatability))
        gap = 360 - sum(_DEGREES * (high - low) for low, high in curve.sampled)
        if gap >= LEAST_BLANK:
            blank.append(f"{gap:.0f} degrees of {curve.joint}")
    return plot(
        "curves",
        *panels,
        layout="half",
        report=report,
        largest=max(
            (ANGLES.factor * max(map(abs, row.values)), row.joint) for row in curves
        ),
        blank=blank,
    )


def _angles(covered: Coverage, joint: str) -> np.ndarray:
    """Return the angles of the samples that were trained on, from -180 to 180 degrees."""
    k = [row.name for row in covered.joints].index(joint)
    training = [s.positions for s in covered.sockets if s.role == "train"]
    angles = np.degrees([q[k] for q in chain(*training)])
    return (angles + 180) % 360 - 180


def _panel(
    curve: JointCurve, y: Axis, angles: np.ndarray, repeatability: float | None
) -> Panel:
    """Return an error curve over a turn, and the angles of the samples [degrees]."""
    panel = Panel(
        f"{curve.joint}, mrad", Axis(-180, 180, "degrees"), y, height=170
    ).grid()
    count = len(curve.values)
    grid = 360 / count * (np.arange(count) - count // 2)
    values = np.roll(curve.values, count // 2)
    band = np.roll(curve.deviations, count // 2)
    panel.area(grid, values - band, values + band, "deviation-area")
    panel.rule("zero", y=0)
    if repeatability:  # an angle that moves a ball 1 m away by so much
        panel.threshold("", y=-repeatability)
        panel.threshold("", y=repeatability)
    panel.line(np.column_stack([grid, values]).tolist(), "change")
    marks = "".join(
        f"M{panel.x(angle):.1f} {panel.bottom - 5:.1f}v5" for angle in angles
    )
    panel.add("path", d=marks, class_="tick-train")
    return panel
