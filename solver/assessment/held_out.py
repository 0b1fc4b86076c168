"""Rows of the verdict on held-out placements and on known distances.

What is judged is ``calibrated.urdf``, since that is what a user loads. Where the full model, which
corrects joint positions first, is another, its figures stand beside. The error alone can be driven
to zero by a model that shrinks the robot to a point, so the distance stands beside it; but for
coordinates that an instrument measured, which tell size as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import msgspec

from ..data import Metrics, mean_metrics
from ..results import PlacementErrors
from .formatting import joined, mm
from .known_distances import KnownDistanceErrors
from .limits import Limit, LimitResult, Limits, limit_row
from .predictions import ModelName, PlacementPrediction, Predictions, norms
from .verdict import INSTRUMENT

NOTHING_HELD_OUT = "no placement was held out; record another and add it by --test"
ONE_SOCKET = "no held-out placement has two sockets, so there is no distance"
NEAREST = 0.1
"""A held-out placement nearer than this to one that was trained on proves nothing [m]."""
SAME, COPIED, LOOKED_AT = 1e-3, 0.5, 200
"""Configurations that differ by less on every joint are the same [rad], [m]; a larger share of them
is a copy; and so many configurations of a placement are looked at."""
CHANCE = 0.05
"""Probability with which the distance errors of a sound calibration are called odd."""


@dataclass(frozen=True)
class HeldOut:
    """Held-out placements: which of them prove something, and why others do not."""

    proving: tuple[str, ...]
    """Names."""
    others: tuple[str, ...]
    """For each other, what it is, in words."""

    @property
    def missing(self) -> str:
        """Reason that there is no held-out error."""
        if not self.others:
            return NOTHING_HELD_OUT
        return f"{joined(self.others)}, which proves nothing; record another {NEAREST:g} m away"


def held_out(predictions: Predictions) -> HeldOut:
    """Return which held-out placements prove something: no copies, no parts of trained ones."""
    reasons = {
        held.name: [
            words
            for trained in predictions.of_role("train")
            if (words := _trained_already(held, trained))
        ]
        for held in predictions.of_role("test")
    }
    return HeldOut(
        tuple(name for name, words in reasons.items() if not words),
        tuple(words[0] for words in reasons.values() if words),
    )


def _trained_already(held: PlacementPrediction, trained: PlacementPrediction) -> str:
    """Return why a placement proves nothing beside one that was trained on; empty where it does."""
    rows = held.measured.positions
    rows = rows[:: -(-len(rows) // LOOKED_AT)]
    alike = [bool((abs(trained.measured.positions - q).max(axis=1) < SAME).any()) for q in rows]
    if sum(alike) > COPIED * len(alike):
        return f"{held.name} is a copy of {trained.name}"
    if held.measured.kind == "points" or trained.measured.kind == "points":
        return ""
    away = float(norms(held.position - trained.position))
    if away >= NEAREST:
        return ""
    return f"{held.name} is at the place of {trained.name}, or a part of it ({mm(away, 0)} away)"


def held_out_rows(predictions: Predictions, limits: Limits) -> list[LimitResult]:
    """Return whether the errors at placements that were not trained on are within their limits."""
    document, which = predictions.document, held_out(predictions)
    tested = [row for row in document.placements if row.role == "test"]
    rows = [row for row in tested if row.name in which.proving]
    by_instrument = bool(rows) and all(row.kind == "points" for row in rows)
    loaded = mean_metrics([row.loaded for row in rows]) if rows else None
    full = mean_metrics([row.calibrated for row in rows]) if rows else None
    if document.summary.test is not None and not which.others:
        loaded, full = document.summary.test.loaded, document.summary.test.calibrated
    if full == loaded:
        full = None
    found = error_rows(loaded, full, limits, which.missing, by_instrument=by_instrument)
    if which.others:
        status = "warning" if which.proving else "not evaluated"
        words = f"{joined(which.others)}, which proves nothing"
        found.append(limit_row("held_out", "what was held out", status, words, text=words))
    odd = _odd_distances(rows)
    return [*(_known_to(row, odd) for row in found), *odd]


def _known_to(row: LimitResult, odd: Sequence[LimitResult]) -> LimitResult:
    """Return the row of the distance as open where its limit is finer than the data can tell."""
    broken = row.name == "distance_error" and {row.status, row.full_status} <= {"fail", None}
    told = next((one.limit or 0.0 for one in odd if one.status == "pass"), 0.0)
    if not broken or (row.limit or 0.0) > told:
        return row
    text = f"{row.text}, but it is known to {mm(told, 3)} only: record more samples in each socket"
    full = None if row.full_status is None else "not enough"
    return msgspec.structs.replace(row, status="not enough", full_status=full, text=text)


def _odd_distances(rows: Sequence[PlacementErrors]) -> list[LimitResult]:
    """Return whether the held-out distances are off by no more than they are known to."""
    known = [
        (abs(row.calibrated.distance_error) / row.distance_deviation, row)
        for row in rows
        if row.distance_deviation and row.calibrated.distance_error is not None
    ]
    if not known:
        return []
    name, title = "distance_deviations", "held-out distance by its own deviation"
    allowed = NormalDist().inv_cdf(1 - CHANCE / 2 / len(known))
    z, worst = max(known, key=lambda pair: pair[0])
    off, deviation = abs(worst.calibrated.distance_error or 0.0), worst.distance_deviation or 0.0
    words = f"at most {allowed:.1f} standard deviations"
    if z <= allowed:
        return [limit_row(name, title, "pass", words, off, allowed * deviation)]
    text = (
        f"at {worst.name} the sockets come out {mm(off)} from what was said, {z:.1f} standard "
        "deviations: the data cannot tell which base's distance is wrong, or moved between its "
        "sockets, there or where it was trained; measure each again"
    )
    return [limit_row(name, title, "not enough", text, off, allowed * deviation)]


def error_rows(
    loaded: Metrics | None,
    full: Metrics | None,
    limits: Limits,
    missing: str,
    *,
    by_instrument: bool = False,
) -> list[LimitResult]:
    """Return whether errors are within their limits.

    Args:
        loaded: Errors by what is loaded; None without any.
        full: By the full model, where that is another.
        limits: What is allowed.
        missing: Why there are no errors.
        by_instrument: Whether all is held against points that an instrument measured.
    """
    return [
        _length_row(
            "mean_absolute_error",
            "held-out error (MAE)",
            limits.mean_absolute_error,
            None if loaded is None else loaded.mean_absolute_error,
            None if full is None else full.mean_absolute_error,
            missing,
        ),
        _length_row(
            "distance_error",
            "held-out distance error",
            limits.distance_error,
            None if loaded is None else loaded.distance_error,
            None if full is None else full.distance_error,
            missing if loaded is None else INSTRUMENT if by_instrument else ONE_SOCKET,
        ),
    ]


def between_row(between: Sequence[KnownDistanceErrors], limit: Limit) -> LimitResult:
    """Return whether distances between placements, measured from outside, come out right."""
    rows = [row for row in between if not row.in_fit]
    missing = "no distance between placements is known; measure one and add it by --known"
    if between:
        missing = "all distances known were used in the fit; add others by --known"

    def mean(model: ModelName) -> float:
        return sum(abs(row.error(model)) for row in rows) / len(rows)

    two = bool(rows) and rows[0].geometric_error is not None
    return _length_row(
        "between_placements",
        "distances between placements",
        limit,
        mean("geometric") if rows else None,
        mean("calibrated") if two else None,
        missing,
    )


def _length_row(
    name: str, title: str, limit: Limit, reached: float | None, full: float | None, missing: str
) -> LimitResult:
    """Return a limit on a length: the values reached [m], or why there is none."""
    if reached is None or limit.value is None:
        reason = missing if reached is None else limit.source
        return limit_row(name, title, "not evaluated", reason, reached, limit.value)
    text = f"{title} {mm(reached, 3)}, limit {mm(limit.value, 3)}"
    if full is not None:
        text += f" (with corrected joint positions {mm(full, 3)})"
    status = "pass" if reached <= limit.value else "fail"
    one = limit_row(name, title, status, limit.source, reached, limit.value, text)
    if full is None:
        return one
    by_full = "pass" if full <= limit.value else "fail"
    return msgspec.structs.replace(one, full=full, full_status=by_full)
