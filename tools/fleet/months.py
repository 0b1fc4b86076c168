"""History of a fleet: each arm in each month, those that changed first."""

import re
from collections.abc import Iterator, Sequence
from itertools import chain

from ...solver.assessment import stamp_of
from .document import FleetArm, FleetMonth

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
    first, last = (month_of(names[0]), month_of(names[-1])) if names else ("", "")
    present = set(map(month_of, names))
    lines = [_session_line(arm, name) for name in names]
    if first and last:
        lines += _unchecked(
            arm, names, [m for m in months if m > first and m not in present]
        )
    lines.sort(key=lambda line: line.session, reverse=True)
    if arm.error is not None:
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


def _unchecked(
    arm: FleetArm, names: Sequence[str], months: Sequence[str]
) -> Iterator[FleetMonth]:
    """Yield the lines of months without a session."""
    for month in months:
        last = max(name for name in names if name < month)
        yield FleetMonth(
            arm=arm.name,
            session=month,
            mean_absolute_error=None,
            text=f"not checked since {last}",
        )


def _line(arm: FleetArm, session: str, error: float | None, text: str) -> FleetMonth:
    return FleetMonth(
        arm=arm.name, session=session, mean_absolute_error=error, text=text
    )
