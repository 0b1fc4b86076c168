"""The document ``fleet.json``: many arms, each calibrated by its own recordings; in SI units."""

from itertools import chain
from pathlib import Path
from typing import Literal
from urllib.parse import quote

from ...solver.assessment import Kind, Outcome, Scope, mm, plural, stamp_of
from ...solver.results import CurveAgreement, Document, ErrorCurves, ParameterValue
from ..report import render
from ..report.figures import Step

FORMAT = "mukca-fleet-1"


class FleetDrift(Document):
    """Errors of the session before's calibration on the recordings of this one."""

    since: str
    """Name of the session before."""
    mean_absolute_error: float
    status: str
    """Of the verdict of ``mukca validate``."""
    text: str
    reason: str
    """The text without the advice that follows it."""


class FleetSession(Document):
    """One arm's recordings of one date, and the calibration by them."""

    name: str
    """Of the folder; empty where the placements lie in the arm's own folder."""
    placements: int
    samples: int
    held_out: bool
    """True if each placement was left out once; else the errors are those of the fit itself."""
    nominal: float
    """Mean absolute error of the nominal model, its ball refitted [m]."""
    calibrated: float
    """Mean absolute error of ``calibrated.urdf`` [m]."""
    distance_error: float | None
    """Mean of the absolute values [m]."""
    status: Outcome | Literal["refused"]
    kind: Kind | None = None
    scope: Scope | None = None
    text: str
    answer: tuple[str, ...] = ()
    """Its verdict in two lines: what the errors were and are, and whether to load it."""
    todo: Step | None = None
    drift: FleetDrift | None = None
    parameters: tuple[ParameterValue, ...] = ()
    curves: ErrorCurves | None = None
    """Error curves of its joints; None where the data support none."""
    outputs: dict[str, str]


class FleetArm(Document):
    """One arm."""

    name: str
    robot: str
    sessions: tuple[FleetSession, ...]
    """By name, which begins with the date where there are several."""
    error: str | None = None
    """The reason that there is no calibration, or none of the last sessions."""
    again: str | None = None
    """The next thing to record or to do; None where all is well."""

    @property
    def exit_status(self) -> int:
        """Exit status that the arm alone would give: 1 for a FAIL or a drift, 3 if open."""
        last = self.sessions[-1] if self.sessions and self.error is None else None
        if last is None or last.status in ("fail", "refused"):
            return 1
        drifted = last.drift is not None and last.drift.status == "fail"
        return 1 if drifted else 3 if last.status == "incomplete" else 0


class FleetParameter(Document):
    """One number over all arms of one model, by their last calibrations."""

    robot: str
    name: str
    unit: str
    arms: int
    mean: float
    """Mean change from nominal: what the model itself has wrong."""
    spread: float | None
    """Standard deviation over the arms: what is each arm's own; None for a single arm."""
    farthest: str
    """The arm that is farthest from the mean."""
    change: float
    """Its change from nominal."""


class FleetCurves(Document):
    """Error curves of two arms of one type, joint by joint: are they alike?"""

    robot: str
    a: str
    b: str
    joints: tuple[CurveAgreement, ...]


class FleetDocument(Document):
    """All of ``fleet.json``."""

    format: str
    arms: tuple[FleetArm, ...]
    parameters: tuple[FleetParameter, ...]
    curves: tuple[FleetCurves, ...] = ()
    """Of all pairs of arms of one type that have them."""


def fleet_page(result: FleetDocument) -> str:
    """Return the fleet as HTML."""
    summary = summary_of(result)
    return render(
        "fleet.html.j2",
        result,
        result=result,
        summary=summary,
        status=_status,
        link=_link,
    )


def summary_of(result: FleetDocument) -> str:
    """Return the state of the fleet in a sentence."""
    last = [
        arm.sessions[-1].status if arm.error is None else "error" for arm in result.arms
    ]
    passed = last.count("pass")
    todo = sum(arm.again is not None for arm in result.arms)
    sessions = chain(*(arm.sessions[-1:] for arm in result.arms))
    drifts = [session.drift for session in sessions if session.drift is not None]
    drifted = sum(drift.status == "fail" for drift in drifts)
    arms = plural(len(result.arms), "arm")
    return f"{passed} of {arms} pass; {drifted} drifted since the session before; {todo} to look at"


def line_of(arm: FleetArm) -> tuple[str, str, str, str, str]:
    """Return an arm's row for a terminal: name, session, nominal, calibrated, verdict."""
    if not arm.sessions:
        return (arm.name, "-", "-", "-", "no calibration")
    session = arm.sessions[-1]
    status = _status(session) if arm.error is None else "no new calibration"
    return (
        arm.name,
        session.name or "-",
        mm(session.nominal),
        mm(session.calibrated),
        status,
    )


def _status(session: FleetSession) -> str:
    return stamp_of(session.status, session.kind)


def _link(arm: FleetArm) -> str:
    """Return the address of the report of an arm's last session, as seen from the page."""
    session = arm.sessions[-1]
    parts = (arm.name, session.name, Path(session.outputs["report"]).name)
    return "/".join(quote(part) for part in parts if part)
