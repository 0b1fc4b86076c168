"""The verdict: each limit passed, failed, or not evaluated, and why.

What is judged is ``calibrated.urdf``, since that is what a user loads. Where the full model, which
corrects joint positions first, is another, its figures stand beside.
"""

from collections.abc import Sequence
from typing import Literal

from ..diagnostics import Diagnostic
from ..results import Document
from .errors import RoleSummary
from .formatting import joined, mm, plural
from .known_distances import KnownDistanceErrors
from .limits import Limit, LimitResult, Limits, Status
from .predictions import ModelName

Outcome = Literal["pass", "fail", "incomplete"]
"""Of a verdict."""
NOTHING_HELD_OUT = "no placement was held out; record another and add it by --test"
ONE_SOCKET = "no held-out placement has two sockets, so there is no distance"
INSTRUMENT = "the held-out error is one of measured coordinates, which no small model can feign"


class Verdict(Document, kw_only=True, frozen=True):
    """Verdict on ``calibrated.urdf`` by its limits."""

    status: Outcome
    title: str
    text: str
    limits: tuple[LimitResult, ...]


def judge(
    held_out: RoleSummary | None,
    between: Sequence[KnownDistanceErrors],
    checks: Sequence[Diagnostic] | None,
    limits: Limits,
    sufficiency: Sequence[LimitResult] = (),
    *,
    by_instrument: bool = False,
) -> Verdict:
    """Return the verdict on a calibration.

    The error alone can be driven to zero by a model that shrinks the robot to a point, so it
    never passes without the distance error beside it; but for coordinates that an instrument
    measured, which tell size as well.

    Args:
        held_out: Errors at the placements that were not trained on; None without any.
        between: Errors of known distances between placements.
        checks: What was found in the recordings; None where they were not checked.
        limits: What is allowed.
        sufficiency: Size of the arm, and amount of the data.
        by_instrument: Whether all that was held out are points that an instrument measured.
    """
    loaded = None if held_out is None else held_out.loaded
    full = None if held_out is None else held_out.calibrated
    rows = (
        _row(
            "mean_absolute_error",
            "held-out error (MAE)",
            limits.mean_absolute_error,
            None if loaded is None else loaded.mean_absolute_error,
            None if full is loaded or full is None else full.mean_absolute_error,
            NOTHING_HELD_OUT,
        ),
        _row(
            "distance_error",
            "held-out distance error",
            limits.distance_error,
            None if loaded is None else loaded.distance_error,
            None if full is loaded or full is None else full.distance_error,
            NOTHING_HELD_OUT if loaded is None else INSTRUMENT if by_instrument else ONE_SOCKET,
        ),
        _between_row(between, limits.between_placements),
        _checks_row(checks),
        *sufficiency,
    )
    status = _status([row.status for row in rows], rows)
    by_full = _status([row.full_status or row.status for row in rows], rows)
    return Verdict(
        status=status, title=_title(rows, status, by_full), text=_text(rows, status), limits=rows
    )


def _status(statuses: Sequence[Status], rows: Sequence[LimitResult]) -> Outcome:
    """Return the verdict that follows from the limits' statuses."""
    if "fail" in statuses:
        return "fail"
    needed = [
        status
        for status, row in zip(statuses, rows, strict=True)
        if row.name in ("mean_absolute_error", "data_checks")
        or (row.name == "distance_error" and row.reason != INSTRUMENT)
    ]
    if "not enough" in statuses or "not evaluated" in needed:
        return "incomplete"
    return "pass"


def _title(rows: Sequence[LimitResult], status: str, by_full: str) -> str:
    if status == "fail":
        if by_full == "pass":
            return "PASS with the corrected joint positions; the URDF alone: FAIL"
        return "FAIL"
    if status == "incomplete":
        enough = all(row.status != "not enough" for row in rows)
        return "NOT VALIDATED" if enough else "NOT ENOUGH DATA TO SAY"
    if any(row.status == "warning" for row in rows):
        return "PASS, with a warning"
    if any(row.status == "not evaluated" for row in rows):
        return "PASS, as far as evaluated"
    return "PASS"


def _text(rows: Sequence[LimitResult], status: str) -> str:
    by_status = {
        status: [row for row in rows if row.status == status]
        for status in ("pass", "warning", "fail", "not enough", "not evaluated")
    }
    if status == "fail":
        words = f"{joined([row.text for row in by_status['fail']])}."
    elif by_status["not enough"]:
        words = f"{'; '.join(row.text for row in by_status['not enough'])}."
    elif by_status["pass"]:
        words = f"Within its limit: {joined([row.title for row in by_status['pass']])}."
    else:
        words = "Nothing was held against a limit."
    words = words[0].upper() + words[1:]
    words += "".join(f" {row.text[0].upper()}{row.text[1:]}." for row in by_status["warning"])
    missing = [row.title for row in by_status["not evaluated"]]
    return words + (f" Not evaluated: {joined(missing)}." if missing else "")


def _row(
    name: str,
    title: str,
    limit: Limit,
    reached: float | None,
    full: float | None,
    missing: str,
) -> LimitResult:
    """Return a limit on a length: the values reached [m], or why there is none."""
    status: Status = "not evaluated"
    full_status: Status | None = None
    if reached is None or limit.value is None:
        reason = missing if reached is None else limit.source
        text = f"{title}: {reason}"
    else:
        status, reason = "pass" if reached <= limit.value else "fail", limit.source
        text = f"{title} {mm(reached, 3)}, limit {mm(limit.value, 3)}"
        if full is not None:
            full_status = "pass" if full <= limit.value else "fail"
            text += f" (with corrected joint positions {mm(full, 3)})"
    return LimitResult(
        name=name,
        title=title,
        found=reached,
        limit=limit.value,
        status=status,
        full=full,
        full_status=full_status,
        text=text,
        reason=reason,
    )


def _between_row(between: Sequence[KnownDistanceErrors], limit: Limit) -> LimitResult:
    rows = [row for row in between if not row.in_fit]
    missing = "no distance between placements is known; measure one and add it by --known"
    if between:
        missing = "all distances known were used in the fit; add others by --known"

    def mean(model: ModelName) -> float:
        return sum(abs(row.error(model)) for row in rows) / len(rows)

    two = bool(rows) and rows[0].geometric_error is not None
    return _row(
        "between_placements",
        "distances between placements",
        limit,
        mean("geometric") if rows else None,
        mean("calibrated") if two else None,
        missing,
    )


def _checks_row(checks: Sequence[Diagnostic] | None) -> LimitResult:
    """Return the row of the data checks: errors fail, warnings are only counted."""
    status: Status = "not evaluated"
    if checks is None:
        reason = "the calibration holds no checks of the recordings; run mukca check"
    else:
        errors = sum(check.level == "error" for check in checks)
        warnings = sum(check.level == "warning" for check in checks)
        status = "fail" if errors else "pass"
        reason = f"{plural(errors, 'error')} and {plural(warnings, 'warning')} in the recordings"
    return LimitResult(
        name="data_checks",
        title="data checks",
        found=None,
        limit=None,
        status=status,
        text=f"data checks: {reason}",
        reason=reason,
    )
