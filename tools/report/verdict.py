"""The verdict: each limit passed, failed, or not evaluated, and why."""

from collections.abc import Mapping
from typing import Any

from .limits import Limit, Limits
from .words import joined, mm, plural

__all__ = ["verdict"]

_TITLES = {"pass": "PASS", "fail": "FAIL", "incomplete": "NOT VALIDATED"}


def verdict(figures: Mapping[str, Any], limits: Limits) -> dict[str, Any]:
    """Return the verdict on a report's figures.

    Returns:
        ``status`` (``pass``, ``fail`` or ``incomplete``), ``title``, ``text`` in words, and
        ``limits``, a row each: ``name``, ``title``, ``status`` (``pass``, ``fail``,
        ``not evaluated``), ``found`` and ``limit`` [m], ``reason`` and ``text``, both in words.
    """
    rows = [
        _held_out(figures, "mean_absolute_error", "held-out error (MAE)", limits),
        _held_out(figures, "distance_error", "held-out distance error", limits),
        _between(figures, limits.between_placements),
        _checks(figures),
    ]
    status = _status(rows)
    partly = status == "pass" and any(row["status"] != "pass" for row in rows)
    return {
        "status": status,
        "title": _TITLES[status] + (", as far as evaluated" if partly else ""),
        "text": _text(rows, status),
        "limits": rows,
    }


def _status(rows: list[dict[str, Any]]) -> str:
    """Return the worst; without both held-out figures nothing is validated.

    The error alone can be driven to zero by a model that shrinks the robot to a point, so it
    never passes without the distance error beside it.
    """
    if any(row["status"] == "fail" for row in rows):
        return "fail"
    return "pass" if all(row["status"] == "pass" for row in rows[:2]) else "incomplete"


def _text(rows: list[dict[str, Any]], status: str) -> str:
    failed = [row["text"] for row in rows if row["status"] == "fail"]
    missing = [row["title"] for row in rows if row["status"] == "not evaluated"]
    passed = [row["title"] for row in rows if row["status"] == "pass"]
    if status == "fail":
        words = f"{joined(failed)}."
    elif passed:
        words = f"Within its limit: {joined(passed)}."
    else:
        words = "Nothing was held against a limit."
    tail = f" Not evaluated: {joined(missing)}." if missing else " Every limit was evaluated."
    return words[0].upper() + words[1:] + tail


def _row(name: str, title: str, limit: Limit, found: float | None, missing: str) -> dict[str, Any]:
    row: dict[str, Any] = {
        "name": name,
        "title": title,
        "found": found,
        "limit": limit.value,
    }
    if found is None or limit.value is None:
        reason = missing if found is None else limit.source
        return {**row, "status": "not evaluated", "text": f"{title}: {reason}", "reason": reason}
    words = f"{title} {mm(found, 3)}, limit {mm(limit.value, 3)}"
    status = "pass" if found <= limit.value else "fail"
    return {**row, "status": status, "text": words, "reason": limit.source}


def _held_out(figures: Mapping[str, Any], key: str, title: str, limits: Limits) -> dict[str, Any]:
    summary = figures["summary"]["test"]
    found = None if summary is None else summary["calibrated"][key]
    missing = "no placement was held out; record another and add it by --test"
    if summary is not None:
        missing = "no held-out placement has two sockets, so there is no distance"
    return _row(key, title, getattr(limits, key), found, missing)


def _between(figures: Mapping[str, Any], limit: Limit) -> dict[str, Any]:
    rows = [row for row in figures["between"] if not row["in_fit"]]
    found = sum(abs(row["calibrated_error"]) for row in rows) / len(rows) if rows else None
    missing = "no distance between placements is known; measure one and add it by --known"
    if figures["between"]:
        missing = "all distances known were used in the fit; add others by --known"
    return _row("between_placements", "distances between placements", limit, found, missing)


def _checks(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return the row of the data checks: errors fail, warnings are only counted."""
    row: dict[str, Any] = {
        "name": "data_checks",
        "title": "data checks",
        "found": None,
        "limit": None,
    }
    checks = figures.get("checks")
    if checks is None:
        reason = "the calibration holds no checks of the recordings; run mukca check"
        return {
            **row,
            "status": "not evaluated",
            "text": f"data checks: {reason}",
            "reason": reason,
        }
    errors = sum(check["level"] == "error" for check in checks)
    warnings = sum(check["level"] == "warning" for check in checks)
    reason = f"{plural(errors, 'error')} and {plural(warnings, 'warning')} in the recordings"
    status = "fail" if errors else "pass"
    return {**row, "status": status, "text": f"data checks: {reason}", "reason": reason}
