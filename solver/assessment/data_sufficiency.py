"""Rows on the recordings: diagnostics, numbers of samples, travel of the joints, accuracy."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ..data import SAMPLES_ADVISED, Measurement, whole_name
from ..diagnostics import predicted_limit
from ..results import (
    Better,
    Diagnostic,
    DistanceDeviation,
    Hypothesis,
    Improvement,
    Scale,
    Uncertainty,
)
from ..robot import InverseKinematics
from .formatting import joined, mm, plural
from .held_out import drift_rows
from .limits import (
    NEAR,
    TITLES,
    WORKSPACE,
    Limit,
    LimitResult,
    Limits,
    Status,
    limit_row,
    with_full,
)
from .predictions import Coverage, Predictions, travels
from .scale_check import (
    assumed_distances,
    distance_row,
    distortion_row,
    most_readings,
    scale_row,
)

WELL_TURNED = math.radians(60)
"""A joint that turned less is named where too little is known [rad]."""
LENGTH_TOLERANCE = 1e-3
"""Links are machined, and a socket base is measured, to this share of their length: no predicted
distance has to be known better."""
SIZE_DEVIATION = 5e-3
"""The paper's method must know an arm's size to this share of it, so that a distance of the sockets
that is 1 % wrong is seen. With 30 samples in each socket it knows it to 0.1 to 0.3 %."""
LEAST_SAMPLES = 10
"""In each of two sockets: fewer determine the sockets' centres and the noise badly."""
LEAST_HELD_OUT = 5
"""In each of two sockets held out: of fewer, the mean follows the single samples."""
LEAST_TRAVEL = math.radians(20)
"""A joint that turned less than this over all that was trained on is hardly seen [rad]."""
LEAST_FREEDOM = 0.01
"""Share of a joint's motion that the ball in its socket allows; an arm of five joints in a plane
cannot turn its first one."""
OF_THE_MODEL = ("copies",)
"""Codes of warnings that no fit makes good. The consequence of others is small, or noise that the
posterior has, or another row judges them."""


def accuracy_rows(
    uncertainty: Uncertainty | None,
    better: Better | None,
    limit: Limit,
    coverage: Coverage,
) -> list[LimitResult]:
    """Return whether the errors of distances that are predicted are small beside the limit."""
    if uncertainty is None:
        words = "how well the calibration is known could not be computed; record more samples"
        return [limit_row("known", "fail", words, text=words)]
    near, everywhere = uncertainty.near, uncertainty.distance_deviation
    rows = [_row(WORKSPACE, everywhere, better and better.workspace, limit, coverage)]
    if near is not None:
        rows.insert(
            0, _row(NEAR, near, better and better.recorded_places, limit, coverage)
        )
    return rows


def _row(
    name: str,
    predicted: DistanceDeviation,
    improvement: Improvement | None,
    limit: Limit,
    coverage: Coverage,
) -> LimitResult:
    """Return whether the upper end of the 68 % interval of an error is within its limit.

    Older files have a standard deviation in its place.
    """
    error = predicted.median if predicted.alone is None else predicted.alone
    by_full_model = None if predicted.alone is None else predicted.median
    if improvement is not None:
        error = improvement.now.high
        by_full_model = improvement.corrected and improvement.corrected.high
    if limit.value is None:
        return limit_row(name, "not evaluated", limit.source, error)
    allowed = predicted_limit(limit.value)
    words = f"{allowed / limit.value:.2g} times the limit on the held-out error"
    if predicted.length is not None and LENGTH_TOLERANCE * predicted.length > allowed:
        allowed = LENGTH_TOLERANCE * predicted.length
        words = f"{100 * LENGTH_TOLERANCE:g} % of {mm(predicted.length)}, their median length"
    text = f"{TITLES[name]} are right to {mm(error)}, where {mm(allowed)} is asked"
    status: Status = "pass"
    if error > allowed:
        status = "not enough"
        text = f"{TITLES[name]} are right to {mm(error)} only, where {mm(allowed)} is asked"
        text += f"; record more varied samples{_least_travel(coverage)}"
        text += ", and a second placement far from the first"
    row = limit_row(name, status, words, error, allowed, text=text)
    return with_full(row, by_full_model, "not enough")


def size_known_row(scale: Scale | None, coverage: Coverage) -> LimitResult:
    """Return whether the paper's method, which predicts no errors, knows the arm's size."""
    deviation = scale and scale.deviation
    if deviation is None or deviation <= SIZE_DEVIATION:
        words = "the paper's method does not say how well it knows; --method auto does"
        return limit_row("known", "warning", words)
    text = (
        f"the arm's size is known to {100 * deviation:.1f} % only, and a wrong distance of the "
        f"sockets could hide in that; record more varied samples{_least_travel(coverage)}, with "
        "sockets farther apart, or use --method auto"
    )
    return limit_row("known", "not enough", text)


def _least_travel(coverage: Coverage) -> str:
    turned = {
        joint: travel
        for joint, travel in travels(coverage).items()
        if travel < WELL_TURNED
    }
    if not turned:
        return ""
    least = min(turned, key=turned.__getitem__)
    return f" ({least} turned by {math.degrees(turned[least]):.0f} deg only)"


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
        assumed=assumed_distances(document),
        readings=most_readings(document.placements),
        tied=bool(document.settings.get("known")),
        causes=document.hypotheses or (),
    )
    rows = recording_rows(document.checks, recordings, drift_doubted=doubted)
    rows += [*drift_rows(predictions, limits), distortion_row(document)]
    rows.append(travel_row(covered, _bound(predictions)))
    if document.uncertainty is None and document.method == "paper":
        return [*rows, size_known_row(document.scale, covered)]
    limit = limits.mean_absolute_error
    return [
        *rows,
        *accuracy_rows(document.uncertainty, document.better, limit, covered),
    ]


@dataclass(frozen=True)
class Recordings:
    """What is judged by ``mukca check`` and by a calibration alike."""

    trained: Sequence[Measurement]
    held_out: Sequence[Measurement] = ()
    scale: Scale | None = None
    """By how much a fit makes the arm larger than its model; None where it does not settle."""
    assumed: Sequence[float] = ()
    """Distances between sockets that nobody measured [m]."""
    readings: int = 1
    """Readings that agree on the distance that the arm's size hangs on."""
    tied: bool = False
    """True where distances between placements were given."""
    causes: Sequence[Hypothesis] = ()
    """Explanations of the recordings."""


def recording_rows(
    checks: Sequence[Diagnostic] | None,
    recordings: Recordings,
    *,
    drift_doubted: bool = False,
) -> list[LimitResult]:
    """Return the one judgement of recordings: diagnostics, distances, size, number of samples."""
    rows = [
        checks_row(checks, drift_doubted=drift_doubted),
        distance_row(recordings.assumed),
    ]
    if recordings.scale is not None:
        distance = next((m.distance for m in recordings.trained if m.has_distance), 0.0)
        scale, causes, readings = (
            recordings.scale,
            recordings.causes,
            recordings.readings,
        )
        rows.append(scale_row(scale, distance, checks, causes, readings=readings))
    return [
        *rows,
        samples_row(recordings.trained, recordings.held_out, tied=recordings.tied),
    ]


def checks_row(
    checks: Sequence[Diagnostic] | None, *, drift_doubted: bool = False
) -> LimitResult:
    """Return the row of the diagnostics: PASS without errors and warnings that concern the model.

    None: no diagnostics were made. With ``drift_doubted`` (held-out limits kept) no drift fails.
    """
    name = "data_checks"
    if checks is None:
        words = "the calibration holds no checks of the recordings; run mukca check"
        return limit_row(name, "not evaluated", words)
    errors = [c for c in checks if c.level == "error"]
    warnings = [c for c in checks if c.level == "warning"]
    reason = f"{plural(len(errors), 'error')} and {plural(len(warnings), 'warning')}"
    reason += " in the recordings"
    drifts = tuple(
        error.where for error in errors if error.code == "drift" and drift_doubted
    )
    if not all(drifts and error.where.startswith(drifts) for error in errors):
        return limit_row(name, "fail", reason)
    doubts = [
        *errors,
        *(warning for warning in warnings if warning.code in OF_THE_MODEL),
    ]
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

    Parts of a recorded placement count together; if ``tied``, sockets of all do.
    """
    counts: dict[str, Counter[int]] = {}
    for m in placements:
        of_sockets = dict(zip(m.sockets, m.counts, strict=True))
        counts.setdefault(whole_name(m.name), Counter()).update(of_sockets)
    by_placement = [list(of_placement.values()) for of_placement in counts.values()]
    of_all = list(chain.from_iterable(by_placement))
    if not by_socket:
        return sum(of_all)
    groups = [of_all] if tied else by_placement
    return max((sorted(group)[-2] for group in groups if len(group) > 1), default=0)


def _bound(predictions: Predictions) -> list[str]:
    """Return the joints that a ball in its socket lets not move, whatever the others do."""
    guide = InverseKinematics(predictions.robot)
    q = [
        p.measured.positions
        for p in predictions.placements
        if p.measured.kind == "sockets"
    ]
    if not q:
        return []
    J = guide.ball_and_neck(np.concatenate(q))[1][:, :3]
    bound = np.einsum("nij,nji->ni", np.linalg.pinv(J, rcond=1e-3), J)
    pairs = zip(
        predictions.robot.joint_names, 1 - np.median(bound, axis=0), strict=True
    )
    return [name for name, freedom in pairs if freedom < LEAST_FREEDOM]


def travel_row(coverage: Coverage, exact: Sequence[str] = ()) -> LimitResult:
    """Return whether each joint turned enough, but those that a socket holds."""
    turned = {
        name: travel for name, travel in travels(coverage).items() if name not in exact
    }
    still = [name for name, travel in turned.items() if travel < LEAST_TRAVEL]
    smallest = math.degrees(min(turned.values(), default=0.0))
    if not still:
        return limit_row(
            "travel", "pass", f"each joint turned {smallest:.0f} deg or more"
        )
    text = (
        f"{joined(still)} turned by {smallest:.0f} deg or little more; record samples in which "
        f"each joint turns by {math.degrees(LEAST_TRAVEL):.0f} deg at least, better 90"
    )
    return limit_row("travel", "not enough", text)
