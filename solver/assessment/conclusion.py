"""The conclusion on a calibration: is it better, is it within its limits, is it to be loaded?"""

from collections.abc import Iterable, Sequence

from msgspec.structs import replace

from ...errors import fixed
from ..results import Better, Hypothesis, Interval, Summary
from .held_out import MeasuredErrors
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


def conclude(
    rows: Sequence[LimitResult],
    better: Better | None,
    held_out: Summary | None,
    rests_on: Sequence[Premise] = (),
    causes: Sequence[Hypothesis] = (),
    measured: MeasuredErrors | None = None,
) -> Verdict:
    """Return the verdict on a calibration.

    Args:
        rows: Limits, and what else bears on the calibration.
        better: Errors before and now; None where no posterior is known.
        held_out: Errors held out, which decide then.
        rests_on: What the answer relies on.
        causes: Explanations of the recordings, the most probable first.
        measured: True errors at held-out points, the authority where there are any.
    """
    contradiction = [
        row for row in rows if row.status == "fail" and row.name not in LIMITS
    ]
    doubts = [row for row in rows if row.status == "not enough" and row.name in DOUBTS]
    held_back = _held_back(rows)
    proved = measured and measured.is_better
    certain = is_better(better, held_out) if proved is None else proved
    status, kind = _outcome(contradiction, doubts, held_back, certain)
    scope: Scope | None = None
    if status == "pass":
        scope = "workspace" if _is_kept(rows, WORKSPACE) else "recorded_places"
    first = [*contradiction, *doubts, *held_back]
    untold = contradiction or [row for row in doubts if row.name in UNTOLD]
    stated = None if untold else better
    odds = "" if stated is None else f" ({in_100(stated.probability)})"
    if measured is not None and proved is not None:
        odds = f" ({measured.text})"
    verdict = replace(
        verdict_of(rows, causes, status, kind, scope),
        use=status in ("pass", "better"),
        better=stated,
        rests_on=tuple(rests_on),
    )
    lines = _answer(verdict, rows, first, odds, certain=bool(certain))
    if measured is not None:
        sizes = [row for row in rows if row.name == "scale" and row.status == "warning"]
        lines += [sentence(row.text) for row in sizes]
    if better and untold:
        lines = [CONTRADICTED, *lines]
    near = " near the recorded places" * (scope == "recorded_places")
    return replace(verdict, title=f"{verdict.title}{near}", answer=tuple(lines))


def _outcome(
    contradiction: Sequence[LimitResult],
    doubts: Sequence[LimitResult],
    held_back: Sequence[LimitResult],
    certain: bool | None,
) -> tuple[Outcome, Kind | None]:
    """Return the outcome: contradictions count first, then doubts, then what holds it back."""
    if contradiction:
        return "fail", None
    if certain and not doubts:
        return ("better", "better") if held_back else ("pass", None)
    few = certain is None or any(row.name in FEW for row in held_back)
    return "incomplete", "not_enough" if doubts or few else "no_better"


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


def _answer(
    verdict: Verdict,
    rows: Sequence[LimitResult],
    first: Sequence[LimitResult],
    odds: str,
    *,
    certain: bool,
) -> list[str]:
    """Return the answer: the errors, whether to load the model, why or on what it relies.

    The ``first`` of the rows are those that say why not.
    """
    better, scope = verdict.better, verdict.scope
    corrected = None if better is None else better.corrected_probability
    reason = [sentence(row.text) for row in first[:1]]
    lines = [] if better is None else [figures_in_words(better)]
    if verdict.use:
        lines.append(f"USE IT: load {URDF}. It is better than your file{odds}.")
        lines += reason or ([] if scope is None else [_limits_kept(rows, scope)])
        premises = _first_of_each(verdict.rests_on)
        lines += [" ".join(premises)] if premises else []
    elif certain:
        lines.append(f"DO NOT LOAD IT: {reason[0]}")
    else:
        not_better = f"{URDF} is not shown to be better than your file{odds}."
        lines += [f"DO NOT LOAD IT: {not_better}", *reason]
    if corrected is not None and corrected >= SURE and better is not None:
        lines.append(corrected_joints_in_words(better, corrected))
    return lines


def _first_of_each(premises: Sequence[Premise]) -> list[str]:
    """Return a premise of each name: the shortest distance changes lengths most."""
    shortest_last = sorted(premises, key=lambda premise: premise.effect or 0.0)
    by_name = {premise.name: premise.text for premise in shortest_last}
    names = dict.fromkeys(premise.name for premise in premises)
    return [by_name[name] for name in names]


def _limits_kept(rows: Sequence[LimitResult], scope: Scope) -> str:
    """Return which limits are kept, and of which the figures leave a doubt of it."""
    words = "All limits are kept"
    if scope == "recorded_places":
        words = "The limits are kept near the recorded places, not in all the workspace"
    doubts = "; ".join(f"the {row.doubt}" for row in rows if row.doubt)
    return f"{words}. Only just: {doubts}." if doubts else f"{words}."


def in_100(probability: float) -> str:
    """Return a probability as "99 in 100"; it is never 0 or 100."""
    return f"{min(max(round(100 * probability), 1), 99)} in 100"


def short_mm(metres: float) -> str:
    """Return millimetres with two digits that count, such as 2.8, 0.23 and 12."""
    value = 1e3 * metres
    return fixed(value, 0 if value >= 9.95 else 1 if value >= 0.995 else 2)


def interval_text(interval: Interval) -> str:
    """Return a 68 % interval [m] in millimetres, as in "68 %: 0.33 to 0.81"."""
    return f"68 %: {short_mm(interval.low)} to {short_mm(interval.high)}"


def figures_in_words(better: Better) -> str:
    """Return the errors of distances before and now."""
    everywhere, recorded = better.workspace, better.recorded_places
    now, before = [short_mm(e.value) for e in (everywhere.now, everywhere.before)]
    if recorded is not None and now == before:
        return (
            f"Near the recorded places a distance is now wrong by about "
            f"{short_mm(recorded.now.value)} mm (was {short_mm(recorded.before.value)}); "
            f"elsewhere by {now}, as before."
        )
    words = (
        f"A distance anywhere in the workspace is now wrong by about {now} mm "
        f"(was {before})"
    )
    if recorded is not None:
        words += f"; near the recorded places by {short_mm(recorded.now.value)}"
    return f"{words}."


def intervals_in_words(better: Better | None) -> list[str]:
    """Return the errors of distances with their intervals, a line for each kind of places."""
    lines: list[str] = []
    if better is None:
        return lines
    for where, errors in (
        ("in the workspace", better.workspace),
        ("near the recorded places", better.recorded_places),
    ):
        if errors is None:
            continue
        named = [("now", errors.now), ("corrected joints", errors.corrected)]
        figures = [f"was {_with_interval(errors.before)}"]
        figures += [f"{name} {_with_interval(one)}" for name, one in named if one]
        lines.append(f"Error of distances {where}, mm: {'; '.join(figures)}.")
    return lines


def _with_interval(error: Interval) -> str:
    return f"{short_mm(error.value)} ({interval_text(error)})"


def corrected_joints_in_words(better: Better, probability: float) -> str:
    """Return where to command with corrected joints, which are better than the nominal model."""
    everywhere, recorded = better.workspace, better.recorded_places
    anywhere = everywhere.corrected
    near = recorded and recorded.corrected
    assert anywhere is not None  # its probability is known
    if anywhere.value <= everywhere.now.value:
        return (
            f"Command with corrected joints: a distance is then wrong by about "
            f"{short_mm(anywhere.value)} mm ({in_100(probability)} that this is better)."
        )
    if recorded is None or near is None or near.value > recorded.now.value:
        return "Corrected joints are no better than this."
    return (
        f"Command with corrected joints near the recorded places only: "
        f"{short_mm(near.value)} mm there, {short_mm(anywhere.value)} elsewhere."
    )
