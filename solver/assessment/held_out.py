"""Rows on held-out placements and known distances, by ``calibrated.urdf``, which a user loads.

Distances are judged, too: a model that shrinks to a point has small errors and wrong distances.
"""

from collections.abc import Mapping, Sequence
from statistics import NormalDist, fmean
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from msgspec import structs

from ..identification.data import (
    NEAREST,
    REPEATED_SHARE,
    Metrics,
    is_copy,
    mean_metrics,
)
from ..results import CalibrationDocument, PlacementErrors
from .errors import KnownDistanceErrors
from .formatting import joined, mm
from .limits import (
    TITLES,
    Limit,
    LimitResult,
    Limits,
    limit_row,
    with_full,
)
from .predictions import PlacementPrediction, Predictions
from .verdict import INSTRUMENT

NOTHING_LEFT_OUT = "nothing was left out, and errors on what was fitted prove nothing"
"""The next step says where to record a second place."""
ONE_SOCKET = "no held-out placement has two sockets, so there is no distance"
SIGNIFICANCE = 0.05
"""Probability that the distance errors of a sound calibration are called implausible."""
DEVIATIONS = 2.0
"""Standard deviations by which true errors have to fall, to be better beyond chance."""


def why_not_held_out(predictions: Predictions) -> dict[str, str]:
    """Return why a held-out placement is not independent, by its name; empty where it is.

    What folds leave out is: they leave out copies and neighbours together.
    """
    training = predictions.of_role("train")
    reasons: dict[str, str] = {}
    for prediction in predictions.of_role("test"):
        words = (_trained_already(prediction, other) for other in training)
        reasons[prediction.name] = next(filter(None, words), "")
    return reasons


def _trained_already(
    prediction: PlacementPrediction, training: PlacementPrediction
) -> str:
    """Return why a held-out placement is not independent of one trained on; empty if it is."""
    pair = (prediction.measured, training.measured)
    if "points" in (pair[0].kind, pair[1].kind):
        is_repeated = is_copy(*pair, REPEATED_SHARE)
        words = f"{prediction.name} repeats the postures of {training.name}"
        return words if is_repeated else ""
    if is_copy(*pair):
        return f"{prediction.name} is a copy of {training.name}"
    distance = float(np.linalg.norm(prediction.position - training.position))
    if distance >= NEAREST:
        return ""
    return (
        f"{prediction.name} is at the place of {training.name}, "
        f"or a part of it ({mm(distance, 0)} away)"
    )


def held_out_rows(predictions: Predictions, limits: Limits) -> list[LimitResult]:
    """Return whether the errors at placements that were not trained on are within their limits."""
    document = predictions.document
    reasons = why_not_held_out(predictions)
    neighbours = list(filter(None, reasons.values()))
    proving = [p for p in predictions.unseen if not reasons.get(p.name)]
    names = {placement.name for placement in proving}
    rows = [p for p in document.unseen if p.name in names]
    loaded = mean_metrics([row.loaded for row in rows]) if rows else None
    corrected = mean_metrics([row.calibrated for row in rows]) if rows else None
    if document.summary.proof is not None and not neighbours:
        loaded = document.summary.proof.loaded
        corrected = document.summary.proof.calibrated
    words = f"{joined(neighbours)}, which proves nothing"
    reason = (
        f"{words}; record another {NEAREST:g} m away"
        if neighbours
        else _why_none_left_out(predictions)
    )
    results = error_rows(
        loaded,
        None if corrected == loaded else corrected,
        limits,
        reason,
        by_instrument=bool(rows) and all(row.kind == "points" for row in rows),
        deviations=_deviations_of(proving, rows),
    )
    if neighbours:
        status = "warning" if proving else "not evaluated"
        results.append(limit_row("held_out", status, words, text=words))
    results += _distance_deviations(rows)
    if predictions.of_role("test"):
        return results
    # what folds leave out was not held out
    return [
        structs.replace(
            row,
            title=row.title.replace("held-out", "left-out"),
            text=row.text.replace("held-out", "left-out"),
        )
        for row in results
    ]


def _why_none_left_out(predictions: Predictions) -> str:
    """Return why nothing was left out: one place alone, all at one place, or nobody wanted it."""
    first, *others = predictions.of_role("train")
    neighbours = [_trained_already(placement, first) for placement in others]
    if not neighbours or not all(neighbours):
        return NOTHING_LEFT_OUT
    words = f"{joined(neighbours)}, so nothing could be left out"
    return f"{words}; record another {NEAREST:g} m away"


class MeasuredErrors(NamedTuple):
    """True errors at held-out points, before a calibration and by ``calibrated.urdf`` [m]."""

    before: float
    now: float
    deviation: float
    """Of the latter, by its scatter."""
    points: int
    unseen: str
    """Says why no fit of them has seen them."""

    @property
    def is_better(self) -> bool | None:
        """True where the errors fell by more than chance, False where they grew; None between."""
        if self.now + DEVIATIONS * self.deviation < self.before:
            return True
        return False if self.now >= self.before else None

    @property
    def text(self) -> str:
        """The errors in words."""
        return f"{mm(self.before, 3)} -> {mm(self.now, 3)} at {self.points} points {self.unseen}"


def measured_errors(predictions: Predictions) -> MeasuredErrors | None:
    """Return the true errors at unseen points that prove something; None without any."""
    reasons = why_not_held_out(predictions)
    pairs = [
        (row, prediction)
        for row, prediction in zip(
            predictions.document.unseen, predictions.unseen, strict=True
        )
        if row.kind == "points" and not reasons.get(row.name)
    ]
    if not pairs:
        return None
    rows = [row for row, _ in pairs]
    deviations = _deviations_of([prediction for _, prediction in pairs], rows)
    is_held_out = any(row.role == "test" for row in rows)
    return MeasuredErrors(
        mean_metrics([row.before for row in rows]).mean_absolute_error,
        mean_metrics([row.loaded for row in rows]).mean_absolute_error,
        deviations["mean_absolute_error"],
        sum(sum(row.samples) for row in rows),
        "not trained on" if is_held_out else "that the fit had not seen",
    )


def worse_in_words(document: CalibrationDocument) -> list[str]:
    """Return a sentence on each unseen placement whose errors grew; none where all fell."""
    zeros = bool(document.settings.get("zeros"))
    why = "; some zeros may rest on it alone" if zeros else ""
    return [
        f"At {row.name} it is worse than your file ({mm(row.before.mean_absolute_error, 3)} -> "
        f"{mm(row.loaded.mean_absolute_error, 3)}) by the fit that did not see it{why}."
        for row in document.unseen
        if row.loaded.mean_absolute_error > row.before.mean_absolute_error
    ]


def _deviations_of(
    predictions: Sequence[PlacementPrediction], rows: Sequence[PlacementErrors]
) -> dict[str, float]:
    """Return the standard deviations of held-out means: of the error, and of the distances [m]."""
    if not predictions:
        return {}
    errors = np.concatenate(
        [prediction.errors("geometric") for prediction in predictions]
    )
    deviations = {"mean_absolute_error": float(errors.std() / len(errors) ** 0.5)}
    lengths = [row.distance_deviation for row in rows if row.distance_deviation]
    if lengths:
        deviations["distance_error"] = float(np.linalg.norm(lengths)) / len(lengths)
    return deviations


def _distance_deviations(rows: Sequence[PlacementErrors]) -> list[LimitResult]:
    """Return whether the errors of held-out distances agree with their standard deviations."""
    candidates: list[tuple[float, float, float, str]] = []
    for row in rows:
        error, deviation = row.calibrated.distance_error, row.distance_deviation
        if error is not None and deviation:
            candidates.append((abs(error) / deviation, abs(error), deviation, row.name))
    if not candidates:
        return []
    allowed = NormalDist().inv_cdf(1 - SIGNIFICANCE / 2 / len(candidates))
    z, error, deviation, worst = max(candidates)
    status = "pass"
    text = f"at most {allowed:.1f} standard deviations"
    if z > allowed:
        status = "not enough"
        text = (
            f"at {worst} the sockets come out {mm(error)} from what was said, {z:.1f} standard "
            "deviations: the data cannot show which base's distance is wrong, or moved between its "
            "sockets, there or where it was trained; measure each again"
        )
    return [limit_row("distance_deviations", status, text, error, allowed * deviation)]


def error_rows(
    loaded: Metrics | None,
    corrected: Metrics | None,
    limits: Limits,
    reason: str,
    *,
    by_instrument: bool = False,
    deviations: Mapping[str, float] = MappingProxyType({}),
) -> list[LimitResult]:
    """Return rows on the errors of ``calibrated.urdf``; ``reason`` says why there are none.

    ``deviations`` has standard deviations of the errors by the rows' names [m].
    """
    no_distance = (
        reason if loaded is None else INSTRUMENT if by_instrument else ONE_SOCKET
    )
    return [
        _length_row(
            name,
            getattr(limits, name),
            loaded and getattr(loaded, name),
            corrected and getattr(corrected, name),
            why,
            deviations.get(name, 0.0),
        )
        for name, why in (
            ("mean_absolute_error", reason),
            ("distance_error", no_distance),
        )
    ]


def between_row(between: Sequence[KnownDistanceErrors], limit: Limit) -> LimitResult:
    """Return whether distances between placements, measured from outside, come out right."""
    rows = [row for row in between if not row.in_fit]
    reason = (
        "no distance between placements is known; measure one and add it by --known"
    )
    if between:
        reason = "all distances known were used in the fit; add others by --known"
    loaded = fmean(abs(row.errors.loaded) for row in rows) if rows else None
    separate = bool(rows) and rows[0].geometric_error is not None
    corrected = fmean(abs(row.errors.calibrated) for row in rows) if separate else None
    return _length_row("between_placements", limit, loaded, corrected, reason)


def _length_row(
    name: str,
    limit: Limit,
    reached: float | None,
    corrected: float | None,
    gap: str,
    deviation: float = 0.0,
) -> LimitResult:
    """Return whether a limit is kept; a figure above it by less than its deviation is undecided."""
    if reached is None or limit.value is None:
        reason = gap if reached is None else limit.source
        return limit_row(name, "not evaluated", reason, reached, limit.value)
    excess = reached - limit.value
    side = "above" if excess > 0 else "within"
    text = f"{TITLES[name]} {mm(reached, 3)}, {side} its limit of {mm(limit.value, 3)}"
    status = "fail" if excess > deviation else "pass"
    if deviation > limit.value or 0 < excess <= deviation:
        status = "not enough"
        text += ": record more samples in each socket, or more placements"
    row = limit_row(
        name,
        status,
        limit.source,
        reached,
        limit.value,
        text=text,
        deviation=deviation or None,
    )
    return with_full(row, corrected, "fail")
