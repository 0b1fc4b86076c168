"""Plots of the model: its parameters, what moved while recording, and the groups of the fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....solver.assessment import Coverage, joined, mm, short_names
from ..figures import HARDLY_MOVED, ReportDocument
from .figure import Axis, Panel, named_rows
from .plot import Plot

_SHOWN = {"m": (1e3, "mm"), "rad": (1e3, "mrad"), "rad/(N m)": (1e6, "\N{MICRO SIGN}rad/(N m)")}
"""Factor and unit on the screen, by SI unit."""
_DEGREES = 180 / np.pi


def shown_unit(unit: str) -> tuple[float, str]:
    """Return the factor and the name of the unit in which people read a parameter."""
    return _SHOWN.get(unit, (1.0, unit))


@dataclass(frozen=True)
class _Bar:
    """Change of a parameter and its standard deviation, 0 where unknown, in the unit shown."""

    name: str
    unit: str
    change: float
    deviation: float


def parameters(report: ReportDocument) -> Plot:
    """Changes by the calibration, as bars, with standard deviations where there are any."""
    kinds: dict[str, list[_Bar]] = {}
    for row in report.parameters:
        kind = "joint origins, places" if row.unit == "m" else "joint origins, angles"
        bar = _bar(row.name, row.unit, row.change, row.standard_deviation)
        kinds.setdefault(kind, []).append(bar)
    for row in report.coefficients or ():
        kind = "elasticity" if row.unit == "rad/(N m)" else "transmission error"
        if row.value or row.standard_deviation:  # the others are switched off
            bar = _bar(row.name, row.unit, row.value, row.standard_deviation)
            kinds.setdefault(kind, []).append(bar)
    largest = [max(bars, key=lambda bar: abs(bar.change)) for bars in kinds.values()]
    changes = joined([f"{bar.name} by {bar.change:+.2f} {bar.unit}" for bar in largest])
    known = [bar for bars in kinds.values() for bar in bars if bar.deviation]
    clear = sum(abs(bar.change) > 2 * bar.deviation for bar in known)
    tail = f"{clear} of the {len(known)} drawn are beyond two of their standard deviations"
    marks = (("change", "change"), ("deviation", "\N{PLUS-MINUS SIGN} one standard deviation"))
    return Plot(
        "parameters",
        "What changed",
        f"The largest changes are {changes}; "
        f"{tail if known else 'this method gives no standard deviations'}.",
        tuple(_bars_panel(kind, bars) for kind, bars in kinds.items()),
        marks if known else marks[:1],
    )


def _bar(name: str, unit: str, change: float, deviation: float | None) -> _Bar:
    factor, shown = shown_unit(unit)
    return _Bar(name, shown, factor * change, factor * (deviation or 0))


def _bars_panel(kind: str, bars: Sequence[_Bar]) -> Panel:
    unit = bars[0].unit
    # Deviations of what no ball can show are far larger than any change; they are cut off.
    largest = max(abs(bar.change) for bar in bars)
    ends = [abs(bar.change) + min(bar.deviation, largest) for bar in bars]
    names = [bar.name.removesuffix(".compliance") for bar in bars]
    panel = named_rows(f"{kind}, {unit}", names, Axis.around_zero(ends, unit), pitch=15)
    panel.rule("zero", x=0)
    for i, bar in enumerate(bars):
        panel.bar(i, 0, bar.change, "change", thick=8)
        if bar.deviation:
            panel.bar(i, bar.change - bar.deviation, bar.change + bar.deviation, "deviation")
    return panel


def coverage(report: ReportDocument) -> Plot:
    """Positions of each joint in each socket, within its limits, and how far it turned."""
    covered = report.coverage
    panels: list[Panel] = []
    for unit, factor, shown in (("rad", _DEGREES, "degrees"), ("m", 1e3, "mm")):
        which = [i for i, joint in enumerate(covered.joints) if joint.unit == unit]
        if which:
            panels += [draw(covered, which, factor, shown) for draw in (_positions, _spans)]
    return Plot(
        "coverage",
        "How the joints moved",
        _coverage_sentence(covered),
        tuple(panels),
        (("tick-train", "trained on"), ("tick-test", "held out"), ("range", "joint limits")),
    )


def _positions(covered: Coverage, joints: Sequence[int], factor: float, unit: str) -> Panel:
    """Return a tick for each position, and the joints' limits."""
    rows = [covered.joints[i] for i in joints]
    ends = [end for row in rows for end in (row.lower, row.upper) if end is not None]
    ends += [end for s in covered.sockets for i in joints for end in (s.low[i], s.high[i])]
    low, high = factor * min(ends), factor * max(ends)
    title = f"positions, {unit}; socket 0 above, others below"
    axis = Axis(low, max(high, low + 1e-6), unit)
    panel = named_rows(title, [row.name for row in rows], axis, pitch=34)
    for k, (i, row) in enumerate(zip(joints, rows, strict=True)):
        if row.lower is not None and row.upper is not None:
            panel.bar(k, factor * row.lower, factor * row.upper, "range", thick=26)
        for role in ("test", "train"):
            marks = "".join(
                f"M{panel.x(factor * q[i]):.1f} {panel.y(k) + (1 if s.socket else -12)}v11"
                for s in covered.sockets
                if s.role == role
                for q in s.positions
            )
            if marks:
                panel.add("path", d=marks, class_=f"tick-{role}")
    return panel


def _spans(covered: Coverage, joints: Sequence[int], factor: float, unit: str) -> Panel:
    """Return a dot for each joint and socket, and the least that a joint should turn."""
    names = [covered.joints[i].name for i in joints]
    spans = [
        (k, factor * (s.high[i] - s.low[i]), s)
        for k, i in enumerate(joints)
        for s in covered.sockets
    ]
    axis = Axis(0, 1.05 * max(*(span for _, span, _ in spans), 1e-6), unit)
    panel = named_rows(f"how far it moved in each socket, {unit}", names, axis, pitch=34)
    for k, span, s in spans:
        hint = f"{s.placement}, socket {s.socket}: {span:.0f} {unit}"
        panel.dot(span, k, f"span-dot {s.role}", hint, size=4)
    if unit == "degrees":
        limit = HARDLY_MOVED * _DEGREES
        panel.threshold(f"at least {limit:.0f} degrees", x=limit)
    return panel


def _coverage_sentence(covered: Coverage) -> str:
    places = short_names([socket.placement for socket in covered.sockets])
    spans = [
        (s.high[i] - s.low[i], joint.name, s.socket, place)
        for i, joint in enumerate(covered.joints)
        if joint.unit == "rad"
        for s, place in zip(covered.sockets, places, strict=True)
    ]
    if not spans:
        return "No joint of this arm turns, so there is no angle to cover."
    span, joint, socket, place = min(spans, key=lambda row: row[0])
    count = sum(row[0] < HARDLY_MOVED for row in spans)
    return (
        f"{joint} moved least, {span * _DEGREES:.0f} degrees in socket {socket} of "
        f"{place}; of {len(spans)} pairs of joint and socket {count or 'none'} moved less than the "
        f"dashed {HARDLY_MOVED * _DEGREES:.0f} degrees."
    )


def groups(report: ReportDocument) -> Plot | None:
    """Effective parameters of each group: those that the data determine, of all there are."""
    rows = [row for row in report.groups or () if row.unit in _SHOWN]
    if not rows:
        return None
    names = [row.name.replace("_", " ") for row in rows]
    panel = named_rows(
        "share of the group that the data settle", names, Axis(0, 100, "%"), pitch=28
    )
    for i, row in enumerate(rows):
        share = 100 * row.effective / max(row.count, 1)
        panel.bar(i, 0, 100, "range", thick=16)
        panel.bar(i, 0, share, "change", thick=16)
        words = f"{row.effective:.1f} of {row.count}" if row.active else "off"
        panel.text(panel.x(min(share, 62)) + 6, panel.y(i) + 4, words, "tick")
    on, off = (
        joined([name for name, row in zip(names, rows, strict=True) if row.active is active])
        for active in (True, False)
    )
    total, count = sum(row.effective for row in rows), sum(row.count for row in rows)
    others = sum(row.count for row in report.groups or ()) - count
    rest = f"; the ball's {others} are not counted here, as it may be anywhere" if others else ""
    return Plot(
        "groups",
        "What the data settle",
        f"The data settle {total:.0f} of {count} parameters, those that are switched off included; "
        f"they support {on or 'no group'}, and switch off {off or 'none'}{rest}.",
        (panel,),
        (("change", "settled by the data"), ("range", "left to the prior")),
        "half",
    )


def joints(report: ReportDocument) -> Plot | None:
    """Displacement of the ball by each joint's calibrated numbers."""
    if report.outlook is None or not report.outlook.joints:
        return None
    rows = report.outlook.joints
    high = 1e3 * max(max(row.recorded, row.workspace) for row in rows)
    axis, names = Axis(0, 1.05 * high, "mm"), [row.joint for row in rows]
    panel = named_rows("what each joint moves the ball by, mm", names, axis)
    for i, row in enumerate(rows):
        panel.bar(i, 0, 1e3 * row.workspace, "link", thick=14)
        panel.bar(i, 0, 1e3 * row.recorded, "change", thick=7)
    most = sorted(rows, key=lambda row: -row.recorded)[:2]
    parts = [f"{mm(row.recorded)} (without that of {row.joint})" for row in most]
    return Plot(
        "joints",
        "Which joint matters",
        f"Without a joint's correction the recorded balls are off by up to {joined(parts)}.",
        (panel,),
        (("change", "in what was recorded"), ("link", "in random poses")),
        "half",
    )
