"""The fleet as a page and on a terminal, and its history: those that changed first."""

import re
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from urllib.parse import quote

from ...solver.assessment import mm, plural, stamp_of
from ..report import render
from ..report.plots import MM, Axis, Panel
from .document import FleetArm, FleetDocument, FleetMonth, FleetSession

DATE = re.compile(r"\d{4}-\d\d")
"""The month, with which the name of a dated session begins."""


def months_of(arms: Sequence[FleetArm]) -> tuple[FleetMonth, ...]:
    """Return a line for each arm and session, and for each month without a session of the arm."""
    names = chain.from_iterable(map(session_names, arms))
    months = sorted({month for name in names if (month := month_of(name))})
    ordered = sorted(arms, key=lambda arm: urgency(arm, months))
    return tuple(chain.from_iterable(_lines(arm, months) for arm in ordered))


def session_names(arm: FleetArm) -> list[str]:
    """Return the names of an arm's sessions, the first one first."""
    names = {row.name for row in arm.sessions} | {row.session for row in arm.checks}
    return sorted(names)


def month_of(name: str) -> str:
    """Return the month of a session, as 2026-06; empty where its name does not begin with one."""
    match = DATE.match(name)
    return match[0] if match else ""


def urgency(arm: FleetArm, months: Sequence[str] = ()) -> tuple[bool, bool, bool]:
    """Return what sorts arms that changed first, then others to look at, then those not checked."""
    names = session_names(arm)
    is_checked = not (months and names) or month_of(names[-1]) == months[-1]
    return not arm.changed, arm.again is None, is_checked


def _lines(arm: FleetArm, months: Sequence[str]) -> list[FleetMonth]:
    """Return the lines of an arm, the last one first."""
    names = session_names(arm)
    present = [*map(month_of, names)]
    lines = [_session_line(arm, name) for name in names]
    for month in months if names and present[0] and present[-1] else ():
        if month > present[0] and month not in present:
            last = max(name for name in names if name < month)
            lines.append(_line(arm, month, None, f"not checked since {last}"))
    lines.sort(key=lambda line: line.session, reverse=True)
    if arm.error:
        lines.insert(0, _line(arm, "", None, "no new calibration: mend the recordings"))
    return lines


def _session_line(arm: FleetArm, name: str) -> FleetMonth:
    """Return the line of a session: its check, its calibration, or both."""
    session = next((row for row in arm.sessions if row.name == name), None)
    check = next((row for row in arm.checks if row.session == name), None)
    error, words = None, list[str]()
    if session is not None:
        error = session.calibrated if session.held_out else None
        words.append(f"calibrated: {stamp_of(session.status, session.kind)}")
    if check is not None:
        error = check.mean_absolute_error
        since = f" since {check.since}" if check.changed and check.since else ""
        words.insert(0, f"{check.change}{since}")
    return _line(arm, name, error, "; ".join(words))


def _line(arm: FleetArm, session: str, error: float | None, text: str) -> FleetMonth:
    return FleetMonth(
        arm=arm.name, session=session, mean_absolute_error=error, text=text
    )


HEIGHT = 180
"""Of the curve of an arm, in the units of its panel."""


def fleet_page(result: FleetDocument) -> str:
    """Return the fleet as HTML."""
    return render(
        "fleet.html.j2",
        result,
        result=result,
        summary=summary_of(result),
        curves=curves_of(result),
        status=_status,
        link=_link,
    )


def curves_of(result: FleetDocument) -> list[Panel]:
    """Return the error of each arm over its sessions, all to one scale, in the order of months."""
    errors = [row.mean_absolute_error for row in result.months]
    limits = [check.limit for arm in result.arms for check in arm.checks]
    y = Axis.from_zero([*errors, *limits], "mean error, mm", MM)
    arms = {arm.name: arm for arm in result.arms if arm.checks}
    names = dict.fromkeys(row.arm for row in result.months)
    return [_curve(arms[name], result, y) for name in names if name in arms]


def _curve(arm: FleetArm, result: FleetDocument, y: Axis) -> Panel:
    """Return the error of one arm over its sessions, with the limit on it."""
    names = session_names(arm)
    panel = Panel(
        arm.name, Axis(-0.4, len(names) - 0.6, ticks=()), y, height=HEIGHT
    ).grid()
    rows = [row for row in result.months if row.arm == arm.name]
    points = [
        (float(names.index(row.session)), row.mean_absolute_error, row)
        for row in reversed(rows)
        if row.session in names and row.mean_absolute_error is not None
    ]
    panel.line([(x, error) for x, error, _ in points], "calibrated")
    for x, error, row in points:
        panel.dot(x, error, "calibrated", f"{row.session}: {mm(error)}, {row.text}", 4)
    for place in sorted({0, len(names) - 1}):
        panel.text(panel.x(place), panel.bottom + 18, names[place], "tick middle")
    panel.threshold("limit {}", y=arm.checks[-1].limit)
    return panel


def summary_of(result: FleetDocument) -> str:
    """Return the state of the fleet in a sentence."""
    passed = sum(arm.exit_status == 0 for arm in result.arms)
    todo = sum(arm.again is not None for arm in result.arms)
    changed = sum(arm.changed for arm in result.arms)
    arms = plural(len(result.arms), "arm")
    return f"{passed} of {arms} pass; {changed} changed; {todo} to look at"


def line_of(arm: FleetArm) -> tuple[str, str, str, str, str]:
    """Return an arm's row for a terminal: name, session, nominal, calibrated, verdict."""
    if not arm.sessions:
        return (arm.name, "-", "-", "-", "no calibration")
    session = arm.sessions[-1]
    name, now = session.name, session.calibrated if session.held_out else None
    status = _status(session)
    if (check := arm.later_check) is not None:
        name, now, status = check.session, check.mean_absolute_error, check.change
    return (
        arm.name,
        name or "-",
        mm(session.nominal),
        "-" if now is None else mm(now),
        status if arm.error is None else "no new calibration",
    )


def _status(session: FleetSession) -> str:
    return stamp_of(session.status, session.kind)


def _link(arm: FleetArm) -> str:
    """Return the address of the report of an arm's last calibration, as seen from the page."""
    session = arm.sessions[-1]
    parts = (arm.name, session.name, Path(session.outputs["report"]).name)
    return "/".join(quote(part) for part in parts if part)
