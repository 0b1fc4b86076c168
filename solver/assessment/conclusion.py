"""The conclusion on a calibration: is it better, is it within its limits, is it to be loaded?"""

from collections.abc import Iterable, Sequence

from msgspec.structs import replace

from ...errors import fixed
from ..results import Better, Hypothesis, Summary
from .formatting import joined, percent
from .limits import LIMITS, NEAR, WORKSPACE, LimitResult
from .verdict import (
    INSTRUMENT,
    Kind,
    Outcome,
    Premise,
    Scope,
    Verdict,
    gaps_of,
    sentence,
    verdict_of,
)

SURE = 0.9
"""Probability of being better from which a model is to be loaded."""
DOUBTS = ("distance_given", "scale", "drift", "data_checks")
"""Rows without whose evidence it cannot be told whether a model is better."""
UNTOLD = ("scale", "drift", "data_checks")
"""Those of them by which no figure of the posterior is to be trusted."""
CONTRADICTED = (
    "How wrong distances are cannot be told: "
    "the recordings contradict each other, or the model."
)
FEW = ("samples", "travel", "known")
"""Rows by which more samples are asked for, where a model is not shown to be better."""
URDF = "calibrated.urdf"
_LOAD, _NOT = "USE IT:", "DO NOT LOAD IT:"


def conclude(
    rows: Sequence[LimitResult],
    better: Better | None,
    held_out: Summary | None,
    rests_on: Sequence[Premise] = (),
    causes: Sequence[Hypothesis] = (),
) -> Verdict:
    """Return the verdict on a calibration.

    Args:
        rows: Limits, and what else bears on the calibration.
        better: Errors before and now; None where no posterior is known.
        held_out: Errors held out, which decide then.
        rests_on: What a PASS rests on.
        causes: Explanations of the recordings, the most probable first.
    """
    contradiction = [
        row for row in rows if row.status == "fail" and row.name not in LIMITS
    ]
    doubts = [row for row in rows if row.status == "not enough" and row.name in DOUBTS]
    held_back = _held_back(rows)
    certain = is_better(better, held_out)
    status: Outcome = "incomplete"
    kind: Kind | None = "no_better"
    if contradiction:
        status, kind = "fail", None
    elif doubts:
        kind = "not_enough"
    elif certain:
        status, kind = ("better", "better") if held_back else ("pass", None)
    elif certain is None or any(row.name in FEW for row in held_back):
        kind = "not_enough"
    scope: Scope | None = None
    if status == "pass":
        scope = "workspace" if _is_kept(rows, WORKSPACE) else "recorded_places"
    use = status in ("pass", "better")
    first = [*contradiction, *doubts, *held_back]
    untold = contradiction or [row for row in doubts if row.name in UNTOLD]
    stated = None if untold else better
    unshown = [row for row in rows if row.doubt]
    lines = _answer(stated, first, unshown, scope, use=use, certain=bool(certain))
    if better and untold:
        lines = [CONTRADICTED, *lines]
    verdict = verdict_of(rows, causes, status, kind, scope)
    return replace(
        verdict,
        title=_title(verdict.title, scope, rests_on),
        answer=tuple(lines),
        use=use,
        better=stated,
        rests_on=tuple(rests_on),
    )


def is_better(better: Better | None, held_out: Summary | None) -> bool | None:
    """Tell whether a model is better than the nominal one; None where nothing says so."""
    if better is not None:
        return better.probability >= SURE
    if held_out is None or held_out.ball_refitted is None:
        return None
    return (
        held_out.loaded.mean_absolute_error < held_out.ball_refitted.mean_absolute_error
    )


def _held_back(rows: Sequence[LimitResult]) -> list[LimitResult]:
    """Return the rows that keep a better model from a PASS, near the recorded places at least."""
    near_is_kept = _is_kept(rows, NEAR)
    missed = [row for row in rows if row.status in ("fail", "not enough")]
    missed = [row for row in missed if not (near_is_kept and row.name == WORKSPACE)]
    return [*missed, *(row for row in gaps_of(rows) if row.reason != INSTRUMENT)]


def _is_kept(rows: Iterable[LimitResult], name: str) -> bool:
    return any(row.name == name and row.status == "pass" for row in rows)


def _title(stamp: str, scope: Scope | None, rests_on: Sequence[Premise]) -> str:
    if scope is None:
        return stamp
    title = stamp if scope == "workspace" else f"{stamp} near the recorded places"
    return (
        f"{title}, if {joined([premise.text for premise in rests_on])}"
        if rests_on
        else title
    )


def _answer(
    better: Better | None,
    first: Sequence[LimitResult],
    unshown: Sequence[LimitResult],
    scope: Scope | None,
    *,
    use: bool,
    certain: bool,
) -> list[str]:
    """Return the two lines: what the errors were and are, and whether to load the model."""
    odds = "" if better is None else f" ({percent(better.probability)})"
    than = f"{URDF} is {'' if certain else 'not shown to be '}better than the nominal model{odds}"
    words = f"{_LOAD if use else _NOT} {than}."
    if not use and certain:
        words = f"{_NOT} {sentence(first[0].text)}"
    elif first:
        words += f" {sentence(first[0].text)}"
    elif scope is not None:
        words += f" {_limits_kept(unshown, scope)}"
    corrected = None if better is None else better.corrected_probability
    if not use and not certain and corrected is not None and corrected >= SURE:
        words += f" With corrected joint positions it is better ({percent(corrected)})."
    return [*([] if better is None else [figures_in_words(better)]), words]


def _limits_kept(unshown: Sequence[LimitResult], scope: Scope) -> str:
    """Return which limits are kept; ``unshown`` are those whose figures leave a doubt of it."""
    near = scope == "recorded_places"
    kept = "all limits"
    if near:
        kept = "its limits near the recorded places"
    words = f"It is within {kept}"
    if unshown:
        words += " as measured"
    if near:
        words += ", not yet in all the workspace"
    return "; ".join([words, *(f"its {row.doubt}" for row in unshown)]) + "."


def figures_in_words(better: Better) -> str:
    """Return the errors of distances before and now."""
    everywhere, recorded = better.workspace, better.recorded_places
    now, corrected = everywhere.now, everywhere.corrected
    words = (
        f"Distances in the workspace were wrong by {_mm(everywhere.before.value)} mm "
        f"and are now by {_mm(now.value)} (68 %: {_mm(now.low)} to {_mm(now.high)})"
    )
    if recorded is not None:
        words += f"; near the recorded places by {_mm(recorded.now.value)}"
    if corrected is not None:
        words += f"; with corrected joint positions by {_mm(corrected.value)}"
        if recorded is not None and recorded.corrected is not None:
            words += f" and {_mm(recorded.corrected.value)}"
    return f"{words}."


def _mm(metres: float) -> str:
    """Return millimetres with two digits that count, such as 2.8, 0.23 and 12."""
    value = 1e3 * metres
    return fixed(value, 0 if value >= 9.95 else 1 if value >= 0.995 else 2)
