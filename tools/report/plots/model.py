"""Plots of the model: parameters, what moved while recording, groups, error curves of joints."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, product
from typing import Any, NamedTuple

import numpy as np

from ....solver.assessment import Coverage, short_names
from ....solver.bayes.model.effects import ANGLES, EFFECTS, Display, effect_named
from ....solver.results import JointCurve
from ..figures import HARDLY_MOVED, ReportDocument
from .axis import Axis
from .figure import Panel, Plot, full_model, in_mm, named_rows, plot

_ORIGINS = {
    "m": Display("mm", 1e3, usual_turn=1.0, heading="joint origins, places"),
    "rad": replace(ANGLES, heading="joint origins, angles"),
}
"""Looks of the numbers of the geometry, by SI unit."""
_NOT_COUNTED = ("ball", "given")
"""Groups of the prior that the plot of groups leaves out."""
_DEGREES = 180 / np.pi
_MRAD = 1e3
LEAST_BLANK = 10.0
"""Angles without samples that are named, all together [degrees]."""


def display_of(name: str, unit: str) -> Display:
    """Return the looks of a parameter, or of a group of them, by its name and SI unit."""
    effect = effect_named(name)
    return effect.display if effect else _ORIGINS.get(unit, Display(unit))


def parameters(report: ReportDocument) -> Plot:
    """Changes by the calibration, as bars, with standard deviations where there are any."""
    rows = [(row, row.change) for row in report.parameters]
    # the coefficients of effects that are switched off are zero for certain
    active = [row for row in report.coefficients or () if row.value or row.standard_deviation]
    rows += [(row, row.value) for row in active]
    bars_by_axis: dict[tuple[str, str, float], list[_Bar]] = {}
    for row, change in rows:
        display = display_of(row.name, row.unit)
        deviation = display.factor * (row.standard_deviation or 0.0)  # 0 where it is not known
        bar = _Bar(row.name, display, display.factor * change, deviation)
        axis = display.heading, display.unit, display.per_mm
        bars_by_axis.setdefault(axis, []).append(bar)
    panels = [*bars_by_axis.values()]
    determined = [bar for bar in chain(*panels) if bar.standard_deviation]
    repeatability = in_mm(report.limits.repeatability)
    usual_words = dict.fromkeys(effect.display.usual_words for effect in EFFECTS.values())
    return plot(
        "parameters",
        *(_bars_panel(bars, repeatability) for bars in panels),
        repeatability=repeatability,
        usual=[words for words in usual_words if words],
        model=full_model(report),
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
    display = bars[0].display
    changes = np.array([bar.value for bar in bars])
    unit = display.unit
    deviations = np.array([bar.standard_deviation for bar in bars])
    # Deviations of what no ball can show are far larger than any change; they are cut off.
    ends = abs(changes) + np.minimum(deviations, abs(changes).max())
    names = [bar.label for bar in bars]
    panel = named_rows(f"{display.heading}, {unit}", names, Axis.around_zero(ends, unit), pitch=15)
    panel.rule("zero", x=0)
    smallest = repeatability * display.per_mm
    panel.thresholds(f"{smallest:g} {unit}", smallest)
    panel.bars(0, changes, "change", thick=8)
    panel.bars(changes - deviations, changes + deviations, "deviation")
    return panel


def coverage(report: ReportDocument) -> Plot:
    """Positions of each joint in each socket, within its limits, and how far it turned."""
    covered = report.coverage
    panels: list[Panel] = []
    for unit, factor, unit_name in (("rad", _DEGREES, "degrees"), ("m", 1e3, "mm")):
        which = [i for i, joint in enumerate(covered.joints) if joint.unit == unit]
        if which:
            panels.append(_positions(covered, which, factor, unit_name))
            panels.append(_spans(covered, which, factor, unit_name))
    places = short_names([socket.placement for socket in covered.sockets])
    sockets = list(zip(covered.sockets, places, strict=True))
    spans = [
        (_DEGREES * (s.high[i] - s.low[i]), joint.name, s.socket, place)
        for (i, joint), (s, place) in product(enumerate(covered.joints), sockets)
        if joint.unit == "rad"
    ]
    return plot("coverage", *panels, spans=spans, limit=HARDLY_MOVED * _DEGREES)


def _positions(covered: Coverage, joint_names: Sequence[int], factor: float, unit: str) -> Panel:
    """Return a tick for each position, and the joints' limits."""
    rows = [covered.joints[i] for i in joint_names]
    limits = factor * np.array([(row.lower, row.upper) for row in rows], dtype=float)
    lows = [factor * s.low[i] for s, i in product(covered.sockets, joint_names)]
    highs = [factor * s.high[i] for s, i in product(covered.sockets, joint_names)]
    low = float(np.nanmin([*limits.ravel(), *lows]))  # NaN: no limit
    high = float(np.nanmax([*limits.ravel(), *highs]))
    title = f"positions, {unit}; socket 0 above, others below"
    axis = Axis(low, max(high, low + 1e-6), unit)
    panel = named_rows(title, [row.name for row in rows], axis, pitch=34)
    panel.bars(limits[:, 0], limits[:, 1], "range", thick=26)
    for (k, i), role in product(enumerate(joint_names), ("test", "train")):
        marks = ""
        for s in covered.sockets:
            if s.role == role:
                y = panel.y(k) + (1 if s.socket else -12)
                marks += "".join(f"M{panel.x(factor * q[i]):.1f} {y}v11" for q in s.positions)
        if marks:
            panel.add("path", d=marks, class_=f"tick-{role}")
    return panel


def _spans(covered: Coverage, joint_names: Sequence[int], factor: float, unit: str) -> Panel:
    """Return a dot for each joint and socket, and the least that a joint should turn."""
    names = [covered.joints[i].name for i in joint_names]
    pairs = list(product(joint_names, covered.sockets))
    spans = [factor * (s.high[i] - s.low[i]) for i, s in pairs]
    axis = Axis(0, 1.05 * max(*spans, 1e-6), unit)
    panel = named_rows(f"how far it moved in each socket, {unit}", names, axis, pitch=34)
    for (i, s), span in zip(pairs, spans, strict=True):
        hint = f"{s.placement}, socket {s.socket}: {span:.0f} {unit}"
        panel.dot(span, joint_names.index(i), f"span-dot {s.role}", hint, size=4)
    if unit == "degrees":
        limit = HARDLY_MOVED * _DEGREES
        panel.threshold(f"at least {limit:.0f} degrees", x=limit)
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
    for i, row in enumerate(rows):
        words = f"{row.effective:.1f} of {row.count}" if row.active else "off"
        panel.text(panel.x(min(shares[i], 62)) + 6, panel.y(i) + 4, words, "tick")
    on = [name for name, row in zip(names, rows, strict=True) if row.active is True]
    inactive = [name for name, row in zip(names, rows, strict=True) if row.active is False]
    count = sum(row.count for row in groups_of_fit) - sum(row.count for row in rows)
    return plot("groups", panel, layout="half", rows=rows, on=on, off=inactive, others=count)


def joints(report: ReportDocument) -> Plot | None:
    """Displacement of the ball by each joint's calibrated numbers."""
    if report.outlook is None or not report.outlook.joints:
        return None
    rows = report.outlook.joints
    names = [row.joint for row in rows]
    recorded = [1e3 * row.recorded for row in rows]
    anywhere = [1e3 * row.workspace for row in rows]
    repeatability = in_mm(report.limits.repeatability)
    axis = Axis(0, 1.05 * max(*recorded, *anywhere, repeatability), "mm")
    panel = named_rows("what each joint moves the ball by, mm", names, axis)
    panel.bars(0, anywhere, "link", thick=14)
    panel.bars(0, recorded, "change", thick=7)
    panel.threshold(f"the arm repeats to {repeatability:g} mm", x=repeatability or None)
    largest = sorted(zip(recorded, names, strict=True), reverse=True)[:2]
    values: dict[str, Any] = {"most": largest, "repeatability": repeatability}
    return plot("joints", panel, layout="half", model=full_model(report), **values)


def error_curves(report: ReportDocument) -> Plot | None:
    """Error curve of each joint, with a band of one standard deviation."""
    if report.curves is None or not report.curves.joints:
        return None
    curves = report.curves.joints
    ends = [np.abs(curve.values) + curve.deviations for curve in curves]
    y = Axis.around_zero([_MRAD * float(np.max(ends))], "mrad")
    repeatability = in_mm(report.limits.repeatability)
    panels: list[Panel] = []
    blank: list[str] = []
    for curve in curves:
        angles = _angles(report.coverage, curve.joint)
        panels.append(_panel(curve, y, angles, repeatability))
        gap = 360 - sum(_DEGREES * (high - low) for low, high in curve.sampled)
        if gap >= LEAST_BLANK:
            blank.append(f"{gap:.0f} degrees of {curve.joint}")
    largest = max((_MRAD * max(map(abs, curve.values)), curve.joint) for curve in curves)
    values: dict[str, Any] = {"largest": largest, "blank": blank, "model": full_model(report)}
    return plot("curves", *panels, layout="half", repeatability=repeatability, **values)


def _angles(covered_range: Coverage, joint: str) -> list[float]:
    """Return the angles of the samples that were trained on, from -180 to 180 degrees."""
    k = [row.name for row in covered_range.joints].index(joint)
    training = [s.positions for s in covered_range.sockets if s.role == "train"]
    return [(_DEGREES * q[k] + 180) % 360 - 180 for q in chain(*training)]


def _panel(curve: JointCurve, y: Axis, angles: list[float], repeatability: float) -> Panel:
    panel = Panel(f"{curve.joint}, mrad", Axis(-180, 180, "degrees"), y, height=170).grid()
    count = len(curve.values)
    angle = 360 / count * (np.arange(count) - count // 2)
    values = _MRAD * np.roll(curve.values, count // 2)
    band = _MRAD * np.roll(curve.deviations, count // 2)
    panel.area(angle, values - band, values + band, "deviation-area")
    panel.rule("zero", y=0)
    for edge in (-repeatability, repeatability) if repeatability else ():
        panel.threshold("", y=edge)
    panel.line(zip(angle.tolist(), values.tolist(), strict=True), "change")
    marks = "".join(f"M{panel.x(a):.1f} {panel.bottom - 5:.1f}v5" for a in angles)
    panel.add("path", d=marks, class_="tick-train")
    return panel
