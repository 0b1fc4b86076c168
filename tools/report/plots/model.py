"""Plots of the model: its parameters, what moved while recording, and the groups of the fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....solver.assessment import Coverage, joined, mm, short_names
from ....solver.results import Outlook
from ..figures import HARDLY_MOVED, ReportDocument
from .figure import Axis, Panel, Rows
from .plot import Plot

_SHOWN = {"m": (1e3, "mm"), "rad": (1e3, "mrad"), "rad/(N m)": (1e6, "\N{MICRO SIGN}rad/(N m)")}
"""Factor and unit on the screen, by SI unit."""
_DEGREES = 180 / np.pi


def shown_unit(unit: str) -> tuple[float, str]:
    """Return the factor and the name of the unit in which people read a parameter."""
    return _SHOWN.get(unit, (1.0, unit))


@dataclass(frozen=True)
class _Bar:
    """A parameter, as it is drawn."""

    name: str
    unit: str
    change: float
    deviation: float | None


def parameters(report: ReportDocument) -> Plot:
    """Changes by the calibration, as bars, with standard deviations where there are any."""
    kinds = _parameter_kinds(report)
    known = any(bar.deviation for bars in kinds.values() for bar in bars)
    marks = (("change", "change"), ("deviation", "\N{PLUS-MINUS SIGN} one standard deviation"))
    return Plot(
        "parameters",
        "What changed",
        _parameter_sentence(kinds),
        tuple(_bars(kind, bars) for kind, bars in kinds.items()),
        marks if known else marks[:1],
    )


def _parameter_kinds(report: ReportDocument) -> dict[str, list[_Bar]]:
    """Return all parameters and coefficients by kind."""
    kinds: dict[str, list[_Bar]] = {}
    for row in report.parameters:
        kind = "joint origins, places" if row.unit == "m" else "joint origins, angles"
        bar = _Bar(row.name, row.unit, row.change, row.standard_deviation)
        kinds.setdefault(kind, []).append(bar)
    for row in report.coefficients or ():
        kind = "elasticity" if row.unit == "rad/(N m)" else "transmission error"
        if row.value or row.standard_deviation:  # the others are switched off
            bar = _Bar(row.name, row.unit, row.value, row.standard_deviation)
            kinds.setdefault(kind, []).append(bar)
    return kinds


def _bars(kind: str, bars: Sequence[_Bar]) -> Panel:
    factor, shown = shown_unit(bars[0].unit)
    # Deviations of what no ball can show are far larger than any change; they are cut off.
    largest = max(abs(bar.change) for bar in bars)
    ends = [abs(bar.change) + min(bar.deviation or 0, largest) for bar in bars]
    half = 1.1 * factor * max(*ends, 1e-9)
    names = [bar.name.removesuffix(".compliance") for bar in bars]
    panel = Rows(f"{kind}, {shown}", names, Axis(-half, half, shown), pitch=15)
    panel.vertical(0, "zero")
    for i, bar in enumerate(bars):
        change, deviation = factor * bar.change, factor * (bar.deviation or 0)
        panel.span(i, 0, change, "change", thick=8)
        if deviation:
            panel.span(i, change - deviation, change + deviation, "deviation", thick=2)
    return panel


def _parameter_sentence(kinds: dict[str, list[_Bar]]) -> str:
    parts: list[str] = []
    for bars in kinds.values():
        factor, shown = shown_unit(bars[0].unit)
        bar = max(bars, key=lambda b: abs(b.change))
        parts.append(f"{bar.name} by {factor * bar.change:+.2f} {shown}")
    known = [
        (bar.change, bar.deviation) for bars in kinds.values() for bar in bars if bar.deviation
    ]
    if not known:
        return f"The largest changes are {joined(parts)}; this method gives no standard deviations."
    clear = sum(abs(change) > 2 * deviation for change, deviation in known)
    return (
        f"The largest changes are {joined(parts)}; {clear} of the {len(known)} drawn are beyond "
        "two of their standard deviations."
    )


def coverage(report: ReportDocument) -> Plot:
    """Positions of each joint in each socket, within its limits, and how far it turned."""
    covered = report.coverage
    turning = [i for i, joint in enumerate(covered.joints) if joint.unit == "rad"]
    sliding = [i for i, joint in enumerate(covered.joints) if joint.unit == "m"]
    panels = [
        draw(covered, which, factor, unit)
        for which, factor, unit in ((turning, _DEGREES, "degrees"), (sliding, 1e3, "mm"))
        if which
        for draw in (_positions, _spans)
    ]
    return Plot(
        "coverage",
        "How the joints moved",
        _coverage_sentence(covered, turning),
        tuple(panels),
        (("tick-train", "trained on"), ("tick-test", "held out"), ("range", "joint limits")),
    )


def _positions(covered: Coverage, joints: Sequence[int], factor: float, unit: str) -> Panel:
    rows = [covered.joints[i] for i in joints]
    lows = [factor * socket.low[i] for socket in covered.sockets for i in joints]
    highs = [factor * socket.high[i] for socket in covered.sockets for i in joints]
    low = min(lows + [factor * row.lower for row in rows if row.lower is not None])
    high = max(highs + [factor * row.upper for row in rows if row.upper is not None])
    panel = Rows(
        f"positions, {unit}; socket 0 above, others below",
        [row.name for row in rows],
        Axis(low, max(high, low + 1e-6), unit),
        pitch=34,
    )
    for k, i in enumerate(joints):
        row = rows[k]
        if row.lower is not None and row.upper is not None:
            panel.span(k, factor * row.lower, factor * row.upper, "range", thick=26)
        for role in ("test", "train"):
            upper, lower = panel.row(k) - 12, panel.row(k) + 1
            marks = "".join(
                f"M{panel.x(factor * q[i]):.1f} {lower if s.socket else upper:.1f}v11"
                for s in covered.sockets
                if s.role == role
                for q in s.positions
            )
            if marks:
                panel.add("path", d=marks, class_=f"tick-{role}")
    return panel


def _spans(covered: Coverage, joints: Sequence[int], factor: float, unit: str) -> Panel:
    names = [covered.joints[i].name for i in joints]
    spans = [
        (k, factor * (s.high[i] - s.low[i]), s)
        for k, i in enumerate(joints)
        for s in covered.sockets
    ]
    high = 1.05 * max(*(span for _, span, _ in spans), 1e-6)
    panel = Rows(f"how far it moved in each socket, {unit}", names, Axis(0, high, unit), pitch=34)
    for k, span, socket in spans:
        hint = f"{socket.placement}, socket {socket.socket}: {span:.0f} {unit}"
        panel.mark(k, span, f"span-dot {socket.role}", hint, size=4)
    if unit == "degrees":
        limit = HARDLY_MOVED * _DEGREES
        panel.upright_threshold(limit, f"at least {limit:.0f} degrees")
    return panel


def _coverage_sentence(covered: Coverage, turning: Sequence[int]) -> str:
    places = short_names([socket.placement for socket in covered.sockets])
    spans = [
        (s.high[i] - s.low[i], covered.joints[i].name, s.socket, place)
        for i in turning
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
    panel = Rows("share of the group that the data settle", names, Axis(0, 100, "%"), pitch=28)
    for i, row in enumerate(rows):
        share = 100 * row.effective / max(row.count, 1)
        panel.span(i, 0, 100, "range", thick=16)
        panel.span(i, 0, share, "change", thick=16)
        words = f"{row.effective:.1f} of {row.count}" if row.active else "off"
        panel.text(panel.x(min(share, 62)) + 6, panel.row(i) + 4, words, "tick")
    on = [name for name, row in zip(names, rows, strict=True) if row.active]
    off = [name for name, row in zip(names, rows, strict=True) if not row.active]
    total, count = sum(row.effective for row in rows), sum(row.count for row in rows)
    others = sum(row.count for row in report.groups or ()) - count
    rest = f"; the ball's {others} are not counted here, as it may be anywhere" if others else ""
    return Plot(
        "groups",
        "What the data settle",
        f"The data settle {total:.0f} of {count} parameters, those that are switched off included; "
        f"they support {joined(on) or 'no group'}, and switch off {joined(off) or 'none'}{rest}.",
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
    names = [row.joint for row in rows]
    panel = Rows("what each joint moves the ball by, mm", names, Axis(0, 1.05 * high, "mm"))
    for i, row in enumerate(rows):
        panel.span(i, 0, 1e3 * row.workspace, "link", thick=14)
        panel.span(i, 0, 1e3 * row.recorded, "change", thick=7)
    return Plot(
        "joints",
        "Which joint matters",
        _joint_sentence(report.outlook),
        (panel,),
        (("change", "in what was recorded"), ("link", "in random poses")),
        "half",
    )


def _joint_sentence(outlook: Outlook) -> str:
    rows = sorted(outlook.joints, key=lambda row: -row.recorded)[:2]
    parts = [f"{mm(row.recorded)} (without that of {row.joint})" for row in rows]
    return f"Without a joint's correction the recorded balls are off by up to {joined(parts)}."
