"""Plots of the model: parameters, groups, joints, and the joints' error curves."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from ....solver.assessment import Coverage
from ....solver.identification.effects import ANGLES, EFFECTS, Display, effect_named
from ....solver.results import JointCurve, ParameterValue
from ..figures import ReportDocument
from .axis import MM, Axis
from .figure import Plot, named_rows, plot
from .panel import Panel

_ORIGINS = {
    "m": Display("mm", 1e3, usual_turn=1.0, heading="joint origins, places"),
    "rad": replace(ANGLES, heading="joint origins, angles"),
}
"""Looks of the numbers of the geometry, by SI unit."""
_NOT_COUNTED = ("ball", "given")
"""Groups of the prior that the plot of groups leaves out."""
LEAST_BLANK = 10.0
"""Angles without samples that are named, all together [degrees]."""


def display_of(name: str, unit: str) -> Display:
    """Return the looks of a parameter, or of a group of them, by its name and SI unit."""
    effect = effect_named(name)
    if effect:
        return effect.display
    return _ORIGINS.get(unit, Display(unit))


class _Bar(NamedTuple):
    """A change as it is drawn, in the unit of its display."""

    name: str
    display: Display
    value: float
    standard_deviation: float
    """0 where it is not known."""

    @property
    def label(self) -> str:
        """The name on the axis."""
        if self.display.by_joint:
            return self.name.rpartition(".")[0]
        return self.name


def parameters(report: ReportDocument) -> Plot:
    """Changes by the calibration, as bars, with standard deviations where there are any."""
    bars = _bars(report)
    determined = [bar for bar in chain(*bars) if bar.standard_deviation]
    clear = [bar for bar in determined if abs(bar.value) > 2 * bar.standard_deviation]
    repeatability = MM * (report.limits.repeatability or 0.0)
    usual = dict.fromkeys(effect.display.usual_words for effect in EFFECTS.values())
    return plot(
        "parameters",
        *(_bars_panel(group, repeatability) for group in bars),
        report=report,
        usual=list(filter(None, usual)),
        largest=[max(group, key=lambda bar: abs(bar.value)) for group in bars],
        known=len(determined),
        clear=len(clear),
    )


def _bars(report: ReportDocument) -> list[list[_Bar]]:
    """Return the changes of all parameters, those in each list on one axis."""
    by_axis: dict[tuple[str, str, float], list[_Bar]] = {}
    for row in (*report.parameters, *(report.coefficients or ())):
        change = row.change if isinstance(row, ParameterValue) else row.value
        deviation = row.standard_deviation or 0.0
        # the coefficients of effects that are switched off are zero for certain
        if not (isinstance(row, ParameterValue) or change or deviation):
            continue
        display = display_of(row.name, row.unit)
        scale = display.factor
        axis = (display.heading, display.unit, display.per_mm)
        bar = _Bar(row.name, display, scale * change, scale * deviation)
        by_axis.setdefault(axis, []).append(bar)
    return list(by_axis.values())


def _bars_panel(bars: Sequence[_Bar], repeatability: float) -> Panel:
    """Return bars of one display, and the changes that move a ball by the repeatability [mm]."""
    display = bars[0].display
    unit = display.unit
    changes = np.array([bar.value for bar in bars])
    deviations = np.array([bar.standard_deviation for bar in bars])
    sizes = np.abs(changes)
    # Deviations of what no ball can show are far larger than any change; they are cut off.
    ends = sizes + np.minimum(deviations, sizes.max())
    axis = Axis.around_zero(ends, unit, smallest=1e-6)
    labels = [bar.label for bar in bars]
    panel = named_rows(f"{display.heading}, {unit}", labels, axis, pitch=15)
    panel.rule("zero", x=0)
    panel.thresholds(f"{{}} {unit}", repeatability * display.per_mm)
    panel.bars(0, changes, "change", thick=8)
    panel.bars(changes - deviations, changes + deviations, "deviation")
    return panel


def groups(report: ReportDocument) -> Plot | None:
    """Effective parameters of each group: those that the data determine, of all there are."""
    rows = [row for row in report.groups or () if row.name not in _NOT_COUNTED]
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
        x = panel.x(min(share, 62)) + 6
        panel.text(x, panel.y(i) + 4, words, "tick")
    by_state: dict[bool | None, list[str]] = {True: [], False: []}
    for name, row in zip(names, rows, strict=True):
        by_state.setdefault(row.active, []).append(name)
    every_count = sum(row.count for row in report.groups or ())
    return plot(
        "groups",
        panel,
        layout="half",
        rows=rows,
        on=by_state[True],
        off=by_state[False],
        others=every_count - sum(row.count for row in rows),
    )


def joints(report: ReportDocument) -> Plot | None:
    """Displacement of the ball by each joint's calibrated numbers."""
    if not report.outlook or not report.outlook.joints:
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
    ranked = sorted(((MM * r.recorded, r.joint) for r in rows), reverse=True)
    return plot(
        "joints",
        panel,
        layout="half",
        report=report,
        most=ranked[:2],
    )


def error_curves(report: ReportDocument) -> Plot | None:
    """Error curve of each joint, with a band of one standard deviation."""
    if not report.curves or not report.curves.joints:
        return None
    curves = report.curves.joints
    ends = [np.abs(curve.values) + curve.deviations for curve in curves]
    y = Axis.around_zero([float(np.max(ends))], "mrad", ANGLES.factor)
    panels: list[Panel] = []
    blank: list[str] = []
    largest: list[tuple[float, str]] = []
    for curve in curves:
        angles = _angles(report.coverage, curve.joint)
        panels.append(_curve_panel(curve, y, angles, report.limits.repeatability))
        error = ANGLES.factor * float(np.abs(curve.values).max())
        largest.append((error, curve.joint))
        gap = 360 - sum(math.degrees(high - low) for low, high in curve.sampled)
        if gap >= LEAST_BLANK:
            blank.append(f"{gap:.0f} degrees of {curve.joint}")
    most = max(largest)
    return plot(
        "curves", *panels, layout="half", report=report, largest=most, blank=blank
    )


def _angles(covered: Coverage, joint: str) -> np.ndarray:
    """Return the angles of the samples that were trained on, from -180 to 180 degrees."""
    k = [row.name for row in covered.joints].index(joint)
    training = [s.positions for s in covered.sockets if s.role == "train"]
    angles = np.degrees([q[k] for q in chain(*training)])
    return (angles + 180) % 360 - 180


def _curve_panel(
    curve: JointCurve,
    y: Axis,
    angles: np.ndarray,
    repeatability: float | None,
) -> Panel:
    """Return an error curve over a turn, and the angles of the samples [degrees]."""
    turn = Axis(-180, 180, "degrees")
    panel = Panel(f"{curve.joint}, mrad", turn, y, height=170).grid()
    count = len(curve.values)
    half = count // 2
    grid = 360 / count * (np.arange(count) - half)
    values, band = np.roll([curve.values, curve.deviations], half, axis=1)
    panel.area(grid, values - band, values + band, "deviation-area")
    panel.rule("zero", y=0)
    if repeatability:  # an angle that moves a ball 1 m away by so much
        panel.threshold("", y=-repeatability)
        panel.threshold("", y=repeatability)
    panel.line(np.column_stack([grid, values]).tolist(), "change")
    marks = ""
    for angle in angles:
        marks += f"M{panel.x(angle):.1f} {panel.bottom - 5:.1f}v5"
    panel.add("path", d=marks, class_="tick-train")
    return panel
