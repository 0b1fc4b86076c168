"""The document ``fleet.json``: many arms, each calibrated by its own recordings; in SI units."""

from typing import Literal

from ...solver.assessment import Kind, Outcome, Scope
from ...solver.results import CurveAgreement, Document, ErrorCurves, ParameterValue
from ..report.figures import Step

FORMAT = "mukca-fleet-2"


class FleetCheck(Document):
    """The calibration that stands, on the recordings of a later session."""

    session: str
    """Name of the later session."""
    since: str
    """Name of the session of the calibration."""
    samples: int
    mean_absolute_error: float | None
    """Of ``calibrated.urdf`` on the recordings of the later session [m]."""
    limit: float | None
    """Limit on this error [m]."""
    status: Outcome
    """Of the verdict of ``mukca validate``; ``incomplete`` where a change is not sure."""
    kind: Kind | None
    changed: bool
    """True where the arm is no more what was calibrated."""
    change: str
    """The change, in few words."""
    reason: str
    advice: str
    """The next step; empty where all is well."""


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
    parameters: tuple[ParameterValue, ...] = ()
    curves: ErrorCurves | None = None
    """Error curves of its joints; None where the data support none."""
    outputs: dict[str, str]


class FleetArm(Document):
    """One arm."""

    name: str
    robot: str
    sessions: tuple[FleetSession, ...]
    """Calibrations by name, which begins with the date where there are several."""
    checks: tuple[FleetCheck, ...] = ()
    """Of the calibration that stood, in each session after it."""
    error: str | None = None
    """The reason that there is no calibration, or none of the last sessions."""
    again: str | None = None
    """The next thing to record or to do; None where all is well."""

    @property
    def last_check(self) -> FleetCheck | None:
        """The check of the last session; None where that is the first."""
        return self.checks[-1] if self.checks else None

    @property
    def later_check(self) -> FleetCheck | None:
        """The check of the last session, where that is no calibration."""
        check = self.last_check
        return check if check and check.session != self.sessions[-1].name else None

    @property
    def changed(self) -> bool:
        """True where the arm changed before its last session."""
        return self.last_check is not None and self.last_check.changed

    @property
    def exit_status(self) -> int:
        """Exit status that the arm alone would give: 1 for a FAIL or a change, 3 if open."""
        if not self.sessions or self.error is not None or self.changed:
            return 1
        if self.later_check is not None:
            return 3 if self.later_check.status == "incomplete" else 0
        statuses = {"fail": 1, "refused": 1, "incomplete": 3}
        return statuses.get(self.sessions[-1].status, 0)


class FleetMonth(Document):
    """One arm in one session, or in a month without any."""

    arm: str
    session: str
    """Name of the session; the month as 2026-06 where there is none."""
    mean_absolute_error: float | None
    """At places that no fit saw [m]: a held-out placement, or the samples of a check."""
    text: str


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
    months: tuple[FleetMonth, ...] = ()
    """By arm, those that changed first, and the last session first."""
    parameters: tuple[FleetParameter, ...]
    curves: tuple[FleetCurves, ...] = ()
    """Of all pairs of arms of one type that have them."""
