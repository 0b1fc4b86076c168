"""The conclusion on a calibration: is it better, is it within its limits, is it to be loaded?"""

from collections.abc import Iterable, Sequence

from msgspec.structs import replace

from ..results import Better, Hypothesis, Summary
from .error_words import figures_in_words, in_100, short_mm
from .held_out import MeasuredErrors
from .limits import LIMITS, NEAR, WORKSPACE, LimitResult
from .verdict import (
    INSTRUMENT,
    NO_MORE_SAMPLES,
    Kind,
    Outcome,
    Premise,
    Scope,
    Verdict,
    gaps_of,
    lacks_a_length_alone,
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
    "mukca cannot say how wrong distances are: "
    "the recordings contradict each other, or they contradict the robot's model."
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
    worse: Sequence[str] = (),
) -> Verdict:
    """Return the verdict on a calibration.

    Args:
        rows: Limits, and what else bears on the calibration.
        better: Errors before and now; None where no posterior is known.
        held_out: Errors held out, which decide then.
        rests_on: What the answer relies on.
        causes: Explanations of the recordings, the most probable first.
        measured: True errors at held-out points, the authority where there are any.
        worse: Sentences on unseen placements whose errors grew.
    """
    contradiction = [
        row for row in rows if row.status == "fail" and row.name not in LIMITS
    ]
    doubts = [row for row in rows if row.status == "not enough" and row.name in DOUBTS]
    doubts.sort(key=lambda row: row.name not in UNTOLD)
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
    odds = measured.text if measured and proved is not None else ""
    verdict = replace(
        verdict_of(rows, causes, status, kind, scope),
        use=status in ("pass", "better"),
        better=stated,
        rests_on=tuple(rests_on),
    )
    lines = _answer(verdict, rows, first, odds, certain=bool(certain))
    if verdict.use:
        lines += worse
    if verdict.use or not (contradiction or doubts):
        lines += corrected_joints_in_words(verdict, held_out)
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
    reason = [NO_MORE_SAMPLES] if lacks_a_length_alone(rows) else []
    reason += [sentence(row.text) for row in first[:1]]
    lines = [] if better is None else [figures_in_words(better)]
    chance = odds or (better and in_100(better.probability))
    told = f" ({chance})" if chance else ""
    if verdict.use:
        lines.append(f"USE IT: load {URDF}. It is better than your file{told}.")
        lines += reason or ([] if scope is None else [_limits_kept(rows, scope)])
        premises = _first_of_each(verdict.rests_on)
        lines += [" ".join(premises)] if premises else []
    elif certain:
        lines.append(f"DO NOT LOAD IT: {' '.join(reason)}")
    else:
        if better and not odds:
            chance = in_100(min(better.probability, SURE - 0.01))
            told = (
                f"; its chance to be better is {chance}, and {in_100(SURE)} are needed"
            )
        not_better = f"{URDF} is not shown to be better than your file{told}."
        lines += [f"DO NOT LOAD IT: {not_better}", *reason]
    return lines


def _first_of_each(premises: Sequence[Premise]) -> list[str]:
    """Return a premise of each name: the shortest distance changes lengths most."""
    shortest_last = sorted(premises, key=lambda premise: premise.effect or 0.0)
    by_name = {premise.name: premise.text for premise in shortest_last}
    names = dict.fromkeys(premise.name for premise in premises)
    return [by_name[name] for name in names]


def _limits_kept(rows: Sequence[LimitResult], scope: Scope) -> str:
    """Return which limits are kept, and of which the figures leave a doubt of it."""
    words = "All errors are within their limits"
    if scope == "recorded_places":
        words = "Errors are within their limits near the recorded places, not in all the workspace"
    doubts = "; ".join(f"the {row.doubt}" for row in rows if row.doubt)
    return f"{words}. Only just: {doubts}." if doubts else f"{words}."


def corrected_joints_in_words(verdict: Verdict, held_out: Summary | None) -> list[str]:
    """Return where corrected joints are better than the nominal model; nothing where nowhere is.

    Errors at places left out are the authority: they need not fall with the predicted ones.
    """
    better = verdict.better
    chance = better and better.corrected_probability
    if better is None or chance is None or chance < SURE:
        return []
    everywhere, recorded = better.workspace, better.recorded_places
    anywhere = everywhere.corrected
    near = recorded and recorded.corrected
    assert anywhere is not None  # its probability is known
    advice = "let mukca correct the joint positions that you send (mukca command)"
    grew = held_out and (
        held_out.calibrated.mean_absolute_error > held_out.loaded.mean_absolute_error
    )
    if anywhere.value <= everywhere.now.value and not grew:
        first = "Better still, load it and" if verdict.use else "With your file,"
        return [
            f"{first} {advice}: a distance is then wrong by about "
            f"{short_mm(anywhere.value)} mm."
        ]
    if grew or recorded is None or near is None or near.value > recorded.now.value:
        return ["Corrected joint positions are no better than this."]
    return [
        f"Near the recorded places only, {advice}: a distance is then wrong by "
        f"{short_mm(near.value)} mm there, {short_mm(anywhere.value)} elsewhere."
    ]
