"""Rows on the recordings: diagnostics, distances, size of the arm, numbers of samples."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

from ..identification.data import SAMPLES_ADVISED, Measurement
from ..results import (
    Better,
    Diagnostic,
    Hypothesis,
    Scale,
)
from .accuracy import accuracy_rows, joints_held, size_known_row, travel_row
from .conclusion import SURE
from .drift import drift_rows
from .formatting import percent, plural
from .limits import (
    LimitResult,
    Limits,
    is_dwarfed,
    limit_row,
)
from .predictions import Coverage, Predictions
from .scale_check import (
    assumed_distances,
    distance_row,
    distortion_row,
    most_readings,
    scale_row,
)

LEAST_SAMPLES = 10
"""In each of two sockets: fewer determine the sockets' centres and the noise badly."""
LEAST_HELD_OUT = 5
"""In each of two sockets held out: of fewer, the mean follows the single samples."""
OF_THE_MODEL = ("copies",)
"""Codes of warnings that no fit makes good. The consequence of others is small, or noise that the
posterior has, or another row judges them."""


def rows_of_the_fit(
    predictions: Predictions,
    covered: Coverage,
    limits: Limits,
    held_out: Sequence[LimitResult],
) -> list[LimitResult]:
    """Return the rows on the recordings, the arm's size, and how much is known by them."""
    document = predictions.document
    proved = [row.name for row in held_out if "pass" in (row.status, row.full_status)]
    doubted = {"mean_absolute_error", "distance_error"} <= set(proved)
    recordings = Recordings(
        [p.measured for p in predictions.of_role("train")],
        [p.measured for p in predictions.of_role("test")],
        document.scale,
        scale_settled=document.settings.get("scale") is not None,
        assumed=assumed_distances(document),
        readings=most_readings(document.placements),
        tied=bool(document.settings.get("known")),
        causes=document.hypotheses or (),
    )
    rows = recording_rows(
        document.checks, recordings, document.better, drift_doubted=doubted
    )
    rows += [*drift_rows(predictions, limits), distortion_row(document)]
    rows.append(travel_row(covered, joints_held(predictions)))
    if document.uncertainty is None and document.method == "paper":
        return [*rows, size_known_row(document.scale, covered)]
    rows += accuracy_rows(
        document.uncertainty, document.better, limits.mean_absolute_error, covered
    )
    return rows


@dataclass(frozen=True)
class Recordings:
    """Figures that ``mukca check`` and a calibration judge alike."""

    trained: Sequence[Measurement]
    held_out: Sequence[Measurement] = ()
    scale: Scale | None = None
    """By how much a fit makes the arm larger than its model; None where it does not settle."""
    scale_settled: bool = False
    """True where the user gave the scale of what measured points."""
    assumed: Sequence[float] = ()
    """Distances between sockets that nobody measured [m]."""
    readings: int = 1
    """Readings that agree on the distance that the arm's size hangs on."""
    tied: bool = False
    """True where distances between placements were given."""
    causes: Sequence[Hypothesis] = ()
    """Explanations of the recordings."""
    better: Better | None = None
    """Errors before and after a calibration on them, where that alone is asked."""


def recording_rows(
    checks: Sequence[Diagnostic] | None,
    recordings: Recordings,
    better: Better | None = None,
    *,
    drift_doubted: bool = False,
) -> list[LimitResult]:
    """Return the one judgement of recordings: diagnostics, distances, size, number of samples.

    ``better`` are the errors before and after a calibration on them.
    """
    rows = [
        checks_row(checks, better, drift_doubted=drift_doubted),
        distance_row(recordings.assumed),
    ]
    if recordings.scale is not None:
        distance = next((m.distance for m in recordings.trained if m.has_distance), 0.0)
        row = scale_row(
            recordings.scale,
            distance,
            checks,
            recordings.causes,
            readings=recordings.readings,
            settled=recordings.scale_settled,
        )
        rows.append(row)
    samples = samples_row(recordings.trained, recordings.held_out, tied=recordings.tied)
    gain = recordings.better
    if samples.status == "not enough" and gain and gain.probability >= SURE:
        # a calibration on few samples may be better: they only bar a PASS
        text = (
            "a calibration on them is better than the nominal model "
            f"({percent(gain.probability)}), but no PASS: {samples.text}"
        )
        samples = limit_row("samples", "warning", samples.reason, text=text)
    return [*rows, samples]


def checks_row(
    checks: Sequence[Diagnostic] | None,
    better: Better | None = None,
    *,
    drift_doubted: bool = False,
) -> LimitResult:
    """Return the row of the diagnostics: PASS without errors and warnings that concern the model.

    None: no diagnostics were made. With ``drift_doubted`` (held-out limits kept) no drift fails.
    An error stops nothing if a model is ``better`` by more than it may cost.
    """
    name = "data_checks"
    if checks is None:
        return limit_row(
            name,
            "not evaluated",
            "the calibration holds no checks of the recordings; run mukca check",
        )
    every_error = [c for c in checks if c.level == "error"]
    warnings = [c for c in checks if c.level == "warning"]
    reason = (
        f"{plural(len(every_error), 'error')} and {plural(len(warnings), 'warning')}"
    )
    reason += " in the recordings"
    errors = [
        error
        for error in every_error
        if (cost := error.consequence) is None
        or not is_dwarfed(better, cost.workspace, cost.near)
    ]
    drifts = tuple(
        error.where for error in errors if error.code == "drift" and drift_doubted
    )
    if not all(drifts and error.where.startswith(drifts) for error in errors):
        return limit_row(name, "fail", reason)
    doubts = [
        *errors,
        *(warning for warning in warnings if warning.code in OF_THE_MODEL),
    ]
    if not doubts and every_error:
        costs = "; ".join(dict.fromkeys(error.words for error in every_error))
        text = f"{costs}; the calibration gains more than that may cost"
        return limit_row(name, "warning", reason, text=text)
    if not doubts:
        return limit_row(name, "pass", reason)
    text = "; ".join(dict.fromkeys(f"{doubt.text}; {doubt.advice}" for doubt in doubts))
    return limit_row(name, "not enough", reason, text=text)


def samples_row(
    training: Sequence[Measurement], held_out: Sequence[Measurement] = (), *, tied: bool
) -> LimitResult:
    """Return whether enough samples lie in each socket, or an instrument measured enough points.

    With ``tied`` sockets, distances between placements were given, so that any two count.
    """
    by_socket = any(m.kind == "sockets" for m in training)
    what, part = "sample", "in a socket "
    advice = f"record at least {{}} in each, better {SAMPLES_ADVISED}"
    if not by_socket:
        what, part, advice = "measured point", "", "measure {} or more"
    trained = _most_samples(training, by_socket=by_socket, tied=tied)
    tested = _most_samples(held_out, by_socket=by_socket, tied=False)
    for role, placements, count, limit in (
        ("trained on", training, trained, LEAST_SAMPLES),
        ("held out", held_out, tested, LEAST_HELD_OUT),
    ):
        least = limit if by_socket else 2 * limit
        if placements and count < least:
            text = f"only {plural(count, what)} {part}{role}; {advice.format(least)}"
            return limit_row("samples", "not enough", text)
    addition = " or more in each socket" if by_socket else ""
    return limit_row("samples", "pass", f"{plural(trained, what)}{addition} trained on")


def _most_samples(
    placements: Sequence[Measurement], *, by_socket: bool, tied: bool
) -> int:
    """Return how many samples each of two sockets has, at the best placement, or all points.

    If ``tied``, the sockets of all placements count together.
    """
    by_placement = [m.counts for m in placements]
    of_all = tuple(chain.from_iterable(by_placement))
    if not by_socket:
        return sum(of_all)
    groups = [of_all] if tied else by_placement
    return max((sorted(group)[-2] for group in groups if len(group) > 1), default=0)
