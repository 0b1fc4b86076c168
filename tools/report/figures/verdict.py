"""The verdict: each limit passed, failed, or not evaluated, and why."""

from collections.abc import Sequence

from ....solver.checks.inspection import Finding
from ...documents.report_errors import KnownDistanceErrors, RoleSummary
from ...documents.report_verdict import Limit, LimitResult, Limits, Verdict
from ..words import joined, mm, plural

__all__ = ["judge"]

_TITLES = {"pass": "PASS", "fail": "FAIL", "incomplete": "NOT VALIDATED"}
NOTHING_HELD_OUT = "no placement was held out; record another and add it by --test"
ONE_SOCKET = "no held-out placement has two sockets, so there is no distance"


def judge(
    held_out: RoleSummary | None,
    between: Sequence[KnownDistanceErrors],
    checks: Sequence[Finding] | None,
    limits: Limits,
) -> Verdict:
    """Return the verdict on a calibration.

    The error alone can be driven to zero by a model that shrinks the robot to a point, so it
    never passes without the distance error beside it.

    Args:
        held_out: Errors at the placements that were not trained on; None without any.
        between: Errors of known distances between placements.
        checks: What was found in the recordings; None where they were not checked.
        limits: What is allowed.
    """
    metrics = None if held_out is None else held_out.calibrated
    rows = (
        _row(
            "mean_absolute_error",
            "held-out error (MAE)",
            limits.mean_absolute_error,
            None if metrics is None else metrics.mean_absolute_error,
            NOTHING_HELD_OUT,
        ),
        _row(
            "distance_error",
            "held-out distance error",
            limits.distance_error,
            None if metrics is None else metrics.distance_error,
            NOTHING_HELD_OUT if metrics is None else ONE_SOCKET,
        ),
        _between_row(between, limits.between_placements),
        _checks_row(checks),
    )
    if any(row.status == "fail" for row in rows):
        status = "fail"
    else:
        status = "pass" if all(row.status == "pass" for row in rows[:2]) else "incomplete"
    partly = status == "pass" and any(row.status != "pass" for row in rows)
    title = _TITLES[status] + (", as far as evaluated" if partly else "")
    return Verdict(status=status, title=title, text=_text(rows, status), limits=rows)


def _text(rows: Sequence[LimitResult], status: str) -> str:
    failed = [row.text for row in rows if row.status == "fail"]
    missing = [row.title for row in rows if row.status == "not evaluated"]
    passed = [row.title for row in rows if row.status == "pass"]
    if status == "fail":
        words = f"{joined(failed)}."
    elif passed:
        words = f"Within its limit: {joined(passed)}."
    else:
        words = "Nothing was held against a limit."
    tail = f" Not evaluated: {joined(missing)}." if missing else " Every limit was evaluated."
    return words[0].upper() + words[1:] + tail


def _row(name: str, title: str, limit: Limit, reached: float | None, missing: str) -> LimitResult:
    """Return a limit on a length: the value reached [m], or why there is none."""
    if reached is None or limit.value is None:
        status, reason = "not evaluated", missing if reached is None else limit.source
        text = f"{title}: {reason}"
    else:
        status, reason = "pass" if reached <= limit.value else "fail", limit.source
        text = f"{title} {mm(reached, 3)}, limit {mm(limit.value, 3)}"
    return LimitResult(
        name=name,
        title=title,
        found=reached,
        limit=limit.value,
        status=status,
        text=text,
        reason=reason,
    )


def _between_row(between: Sequence[KnownDistanceErrors], limit: Limit) -> LimitResult:
    errors = [abs(row.calibrated_error) for row in between if not row.in_fit]
    missing = "no distance between placements is known; measure one and add it by --known"
    if between:
        missing = "all distances known were used in the fit; add others by --known"
    mean = sum(errors) / len(errors) if errors else None
    return _row("between_placements", "distances between placements", limit, mean, missing)


def _checks_row(checks: Sequence[Finding] | None) -> LimitResult:
    """Return the row of the data checks: errors fail, warnings are only counted."""
    if checks is None:
        status = "not evaluated"
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
