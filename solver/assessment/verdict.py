"""A verdict as one value, from which terminal, page and JSON are drawn; and that of recordings."""

from collections.abc import Iterable, Sequence
from typing import Any, Literal

import msgspec

from ..diagnostics import SIZE_BY_DISTANCE, cause
from ..results import Better, Document, Hypothesis
from .formatting import joined
from .limits import LIMITS, LimitResult, Status

Outcome = Literal["pass", "better", "fail", "incomplete"]
Kind = Literal["better", "no_better", "not_enough", "not_validated"]
Scope = Literal["workspace", "recorded_places"]
INSTRUMENT = (
    "an instrument measured the held-out points, "
    "so a wrong size of the arm shows in their errors"
)
NO_MORE_SAMPLES = "The samples are enough; only the sockets' distance is missing."
"""Said where nothing but the distance of the sockets is missing."""
NEEDED = ("mean_absolute_error", "distance_error", "data_checks")
"""Rows without which nothing is validated."""
STAMPS: dict[tuple[str, str | None], str] = {
    ("pass", None): "PASS",
    ("better", "better"): "BETTER",
    ("fail", None): "FAIL",
    ("incomplete", "no_better"): "NO BETTER",
    ("incomplete", "not_enough"): "NOT ENOUGH DATA",
    ("incomplete", "not_validated"): "NOT VALIDATED",
}
"""Titles of verdicts by status and kind."""
_EXIT: dict[Outcome, int] = {"pass": 0, "better": 1, "fail": 1, "incomplete": 3}


class Premise(Document):
    """A premise that no recording can test."""

    name: str
    text: str
    """A sentence."""
    value: float | None = None
    """The distance between sockets [m]; None, here and below, for other premises."""
    source: str | None = None
    """Source of the distance: ``given`` by the user, the ``recording``, ``located``."""
    effect: float | None = None
    """Share by which every length changes if that distance is 0.1 mm more."""


class Verdict(Document):
    """Verdict on a model: is it better than the nominal one, and within its limits?"""

    status: Outcome
    kind: Kind | None
    """``better``, for a status that says so, or the reason of ``incomplete``; None for others."""
    scope: Scope | None
    """Places for which a PASS holds; None for others."""
    title: str
    text: str
    """Reasons, in words."""
    answer: tuple[str, ...] = ()
    """Errors before and now, whether to load the model, and on what that relies: a line each."""
    use: bool | None = None
    """True where ``calibrated.urdf`` is to be loaded; None where that was not asked."""
    better: Better | None = None
    """Errors before and now, and the probability that they are smaller; None where not known."""
    limits: tuple[LimitResult, ...]
    """Limits on figures that are there."""
    reasons: tuple[LimitResult, ...] = ()
    """Other reasons of the verdict: faults, and what is missing."""
    rests_on: tuple[Premise, ...] = ()

    @property
    def exit_status(self) -> int:
        """Exit status of a command that ends with this verdict."""
        return _EXIT[self.status]

    @property
    def colour(self) -> Outcome:
        """Status that its colour shows: a better model that misses a limit is no success."""
        return "incomplete" if self.status == "better" else self.status

    @property
    def stamp(self) -> str:
        """The title without its conditions, as in "NO BETTER"."""
        return self.title.partition(";")[0]

    def status_of(self, name: str) -> Status:
        """Return the status of a row by its name; what is no reason is ``pass``."""
        for row in (*self.limits, *self.reasons):
            if row.name == name:
                return row.status
        return "pass"

    def as_said(self) -> dict[str, Any]:
        """Return the verdict by name without its rows, as the command line's JSON has it."""
        names = ("status", "kind", "scope", "title", "text", "answer", "use")
        document = {name: getattr(self, name) for name in names}
        better = msgspec.to_builtins(self.better)
        if self.better is not None:
            properties = "probability", "corrected_probability"
            better |= {name: getattr(self.better, name) for name in properties}
        return {**document, "better": better}


def stamp_of(status: str, kind: str | None) -> str:
    """Return the title of a verdict."""
    return STAMPS.get((status, kind), status)


def worst(statuses: Iterable[int]) -> int:
    """Return the exit status that stands for several: any failure first, then what is open."""
    present = set(statuses)
    return next((status for status in (1, 3) if status in present), 0)


def gaps_of(rows: Iterable[LimitResult]) -> list[LimitResult]:
    """Return the rows without which there is no PASS, and that nothing evaluated."""
    return [row for row in rows if row.status == "not evaluated" and row.name in NEEDED]


def judge(
    rows: Sequence[LimitResult],
    causes: Sequence[Hypothesis] = (),
    *,
    better: bool = False,
) -> Verdict:
    """Return the verdict on recordings, or on later samples, that follows from rows alone.

    A model that is ``better`` than the nominal one, and misses nothing but limits, is told so.
    """
    failed = [row.name for row in rows if row.status == "fail"]
    statuses = {row.status for row in rows}
    if failed:
        if better and set(failed) <= set(LIMITS):
            return verdict_of(rows, causes, "better", "better")
        return verdict_of(rows, causes, "fail")
    if "not enough" in statuses:
        return verdict_of(rows, causes, "incomplete", "not_enough")
    if gaps_of(rows):
        return verdict_of(rows, causes, "incomplete", "not_validated")
    return verdict_of(rows, causes, "pass", scope="workspace")


def verdict_of(
    rows: Sequence[LimitResult],
    causes: Sequence[Hypothesis],
    status: Outcome,
    kind: Kind | None = None,
    scope: Scope | None = None,
) -> Verdict:
    """Return the verdict of a status, with its rows and reasons."""
    texts = [reasons_in_words(rows, status)]
    of_size = any(one.name in SIZE_BY_DISTANCE for one in causes[:1])
    if status != "pass" and not (of_size and "scale" in _lacking(rows)):
        likeliest = cause(causes)
        texts.insert(lacks_a_length_alone(rows), likeliest and sentence(likeliest))
    return Verdict(
        status=status,
        kind=kind,
        scope=scope,
        title=STAMPS[status, kind],
        text=" ".join(filter(None, texts)) or "Nothing was held against a limit.",
        limits=tuple(filter(is_limit, rows)),
        reasons=tuple(filter(is_reason, rows)),
    )


def _lacking(rows: Iterable[LimitResult]) -> list[str]:
    """Return the names of rows that bar a PASS."""
    return [row.name for row in rows if row.status in ("fail", "not enough")]


def lacks_a_length_alone(rows: Iterable[LimitResult]) -> bool:
    """Tell whether a PASS wants nothing but the distance of the sockets."""
    return _lacking(rows) == ["distance_given"]


def is_limit(row: LimitResult) -> bool:
    """Tell whether a row holds a figure against a limit."""
    return row.name in LIMITS and row.found is not None and row.limit is not None


def is_reason(row: LimitResult) -> bool:
    """Tell whether a row is no limit, but bears on the verdict all the same."""
    unasked = (
        row.name in LIMITS and row.name not in NEEDED and row.status == "not evaluated"
    )
    return not is_limit(row) and row.status != "pass" and not unasked


def sentence(words: str) -> str:
    """Return words as a sentence."""
    return f"{words[:1].upper()}{words[1:]}".rstrip(".") + "."


def reasons_in_words(rows: Sequence[LimitResult], status: Outcome) -> str:
    """Return what keeps a verdict from PASS, or the limits that are kept, then warnings."""

    def texts(of_status: Status) -> list[str]:
        return [sentence(row.text) for row in rows if row.status == of_status]

    words: list[str] = []
    limits_met = [row.title for row in rows if row.status == "pass" and is_limit(row)]
    if limits_met and status == "pass":
        words.append(f"Within its limit: {joined(limits_met)}.")
    if lacks_a_length_alone(rows):
        words.append(NO_MORE_SAMPLES)
    broken = texts("fail") or texts("not enough")
    if status != "pass" and not broken:
        broken = [sentence(row.text) for row in gaps_of(rows)[:1]]
    return " ".join([*words, *broken, *texts("warning")])
