"""The one judge of a robot's model: rows, each a limit that is kept or not, become one verdict."""

from collections.abc import Iterable, Sequence
from typing import Literal

from msgspec.structs import replace

from ..diagnostics import cause
from ..results import Document, Hypothesis
from .formatting import joined, mm
from .limits import NEAR, WORKSPACE, LimitResult, Status, predicted_limit

Outcome = Literal["pass", "fail", "incomplete"]
Kind = Literal["not_enough", "not_validated"]
Scope = Literal["workspace", "recorded_places"]
INSTRUMENT = "the held-out error is one of measured coordinates, which no small model can feign"
NEEDED = ("mean_absolute_error", "distance_error", "data_checks")
"""Rows without which nothing is validated."""
_OPEN = {"not_enough": "NOT ENOUGH DATA", "not_validated": "NOT VALIDATED"}
_EXIT: dict[Outcome, int] = {"pass": 0, "fail": 1, "incomplete": 3}


class Premise(Document, kw_only=True, frozen=True):
    """A premise of a PASS that no recording can test."""

    name: str
    text: str
    value: float | None = None
    """The distance between sockets [m]; None, here and below, for other premises."""
    source: str | None = None
    """Source of the distance: ``given`` by the user, the ``recording``, ``located``."""
    effect: float | None = None
    """Share by which every length changes if that distance is 0.1 mm more."""


class Verdict(Document, kw_only=True, frozen=True):
    """Verdict on a model by its limits."""

    status: Outcome
    kind: Kind | None
    """Reason that the status is ``incomplete``; None for others."""
    scope: Scope | None
    """Where a PASS holds; None for others."""
    title: str
    text: str
    limits: tuple[LimitResult, ...]
    rests_on: tuple[Premise, ...] = ()

    @property
    def exit_status(self) -> int:
        """Exit status of a command that ends with this verdict."""
        return _EXIT[self.status]

    @property
    def stamp(self) -> str:
        """The title without its conditions, as in "NOT VALIDATED"."""
        return self.title.partition(", if ")[0].partition(";")[0]

    def as_said(self) -> dict[str, object]:
        """Return the verdict by name without its rows, as the command line's JSON has it."""
        names = ("status", "kind", "scope", "title", "text")
        return {name: getattr(self, name) for name in names}


def worst(statuses: Iterable[int]) -> int:
    """Return the exit status that stands for several: any failure first, then what is open."""
    found = set(statuses)
    return next((status for status in (1, 3) if status in found), 0)


def judge(
    rows: Sequence[LimitResult], rests_on: Sequence[Premise] = (), causes: Sequence[Hypothesis] = ()
) -> Verdict:
    """Return the verdict that follows from rows, what a PASS ``rests_on``, and likely ``causes``.

    A row that fails is a FAIL, unless the URDF, which has no elasticity, exceeds the limit by
    little and the full model keeps it. That narrows a PASS to the recorded places, as a large
    predicted error in the whole workspace does.
    """
    by_full, _ = _outcome(rows, [row.full_status or row.status for row in rows])
    exceeded = _slightly_exceeded(rows) if by_full == "pass" else []
    rows = [replace(row, status="warning") if row in exceeded else row for row in rows]
    status, kind = _outcome(rows, [row.status for row in rows])
    scope: Scope | None = None
    if status == "pass":
        known = any(row.name == WORKSPACE and row.status == "pass" for row in rows) and not exceeded
        scope = "workspace" if known else "recorded_places"
    words = cause(causes)
    first = f"{words[0].upper()}{words[1:]}. " if words and status != "pass" else ""
    return Verdict(
        status=status,
        kind=kind,
        scope=scope,
        title=_OPEN[kind] if kind else _title(rows, exceeded, scope, by_full, rests_on),
        text=first + _text(rows, status),
        limits=tuple(rows),
        rests_on=tuple(rests_on),
    )


def _outcome(
    rows: Sequence[LimitResult], statuses: Sequence[Status]
) -> tuple[Outcome, Kind | None]:
    pairs = list(zip(rows, statuses, strict=True))
    if "fail" in statuses:
        return "fail", None
    near = any(row.name == NEAR and status == "pass" for row, status in pairs)
    short = [row for row, status in pairs if status == "not enough"]
    if any(not (near and row.name == WORKSPACE) for row in short):
        return "incomplete", "not_enough"
    missing = [row for row, status in pairs if status == "not evaluated" and row.name in NEEDED]
    if any(row.reason != INSTRUMENT for row in missing):
        return "incomplete", "not_validated"
    return "pass", None


def _slightly_exceeded(rows: Sequence[LimitResult]) -> list[LimitResult]:
    """Return the rows that fail, if all exceed their limit by no more than predictions may."""
    broken = [row for row in rows if row.status == "fail"]
    near = [row for row in broken if (row.found or 0.0) <= predicted_limit(row.limit or 0.0)]
    return broken if len(near) == len(broken) else []


def _title(
    rows: Sequence[LimitResult],
    exceeded: Sequence[LimitResult],
    scope: Scope | None,
    by_full: str,
    rests_on: Sequence[Premise],
) -> str:
    if scope is None:
        apart = by_full == "pass" and any(row.full_status for row in rows)
        return "FAIL for the URDF alone; PASS with corrected joint positions" if apart else "FAIL"
    title = "PASS" if scope == "workspace" else "PASS near the recorded places"
    title += " with corrected joint positions" if exceeded else ""
    if rests_on:
        title += f", if {joined([one.text for one in rests_on])}"
    for row in exceeded:
        alone, most = mm(row.found or 0.0), mm(row.limit or 0.0)
        title += f"; the {row.title} of the URDF alone is {alone}, where {most} is asked"
    elsewhere = next((row for row in rows if row.name == WORKSPACE), None)
    if scope == "workspace" or elsewhere is None:
        return title
    if elsewhere.found is None:
        return f"{title}; nothing is known of the rest of the workspace"
    found, full = mm(elsewhere.found), elsewhere.full
    found += "" if full is None else f" ({mm(full)} with corrected joint positions)"
    return f"{title}; in the whole workspace distances are known to {found}"


def _text(rows: Sequence[LimitResult], status: Outcome) -> str:
    by_status = {
        status: [row for row in rows if row.status == status]
        for status in ("pass", "warning", "fail", "not enough", "not evaluated")
    }
    if status == "fail":
        words = f"{joined([row.text for row in by_status['fail']])}."
    elif status != "pass" and by_status["not enough"]:
        words = f"{'; '.join(row.text for row in by_status['not enough'])}."
    elif status != "pass":
        words = next(f"{row.text}." for row in by_status["not evaluated"] if row.name in NEEDED)
    elif by_status["pass"]:
        words = f"Within its limit: {joined([row.title for row in by_status['pass']])}."
    else:
        words = "Nothing was held against a limit."
    words = words[0].upper() + words[1:]
    words += "".join(f" {row.text[0].upper()}{row.text[1:]}." for row in by_status["warning"])
    missing = [row.title for row in by_status["not evaluated"]]
    return words + (f" Not evaluated: {joined(missing)}." if missing else "")
