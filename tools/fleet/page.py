"""The page of a fleet, and its lines on a terminal."""

from pathlib import Path
from urllib.parse import quote

from ...solver.assessment import mm, plural
from ..report.page import render
from .document import FleetArm, FleetDocument, FleetSession


def fleet_page(result: FleetDocument) -> str:
    """Return the fleet as HTML."""
    summary = summary_of(result)
    return render(
        "fleet.html.j2", result, result=result, summary=summary, status=_status, link=_link
    )


def summary_of(result: FleetDocument) -> str:
    """Return the state of the fleet in a sentence."""
    last = [arm.sessions[-1].status if arm.error is None else "error" for arm in result.arms]
    passed = last.count("pass")
    todo = sum(arm.again is not None for arm in result.arms)
    drifted = sum(
        session.drift is not None and session.drift.status == "invalid"
        for arm in result.arms
        for session in arm.sessions[-1:]
    )
    arms = plural(len(result.arms), "arm")
    return f"{passed} of {arms} pass; {drifted} drifted since the session before; {todo} to look at"


def line_of(arm: FleetArm) -> tuple[str, str, str, str, str]:
    """Return an arm's row for a terminal: name, session, nominal, calibrated, verdict."""
    if not arm.sessions:
        return (arm.name, "-", "-", "-", "no calibration")
    session = arm.sessions[-1]
    status = _status(session) if arm.error is None else "no calibration of the last session"
    return (arm.name, session.name or "-", mm(session.nominal), mm(session.calibrated), status)


def _status(session: FleetSession) -> str:
    words = {"pass": "PASS", "fail": "FAIL", "incomplete": "NOT ENOUGH DATA"}
    if session.kind == "not_validated":
        return "NOT VALIDATED"
    return words.get(session.status, session.status)


def _link(arm: FleetArm) -> str:
    """Return the address of the report of an arm's last session, as seen from the page."""
    session = arm.sessions[-1]
    parts = (arm.name, session.name, Path(session.outputs["report"]).name)
    return "/".join(quote(part) for part in parts if part)
