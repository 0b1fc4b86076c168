"""Rows on held-out placements and known distances, by ``calibrated.urdf``, which a user loads.

Distances are judged, too: a model that shrinks to a point has small errors and wrong distances.
"""

from collections.abc import Mapping, Sequence
from statistics import NormalDist, fmean
from types import MappingProxyType

import numpy as np

from ..data import Metrics, mean_metrics
from ..diagnostics import SEVERE, predicted_limit
from ..results import PlacementErrors, Role
from .errors import KnownDistanceErrors
from .formatting import joined, mm
from .limits import TITLES, Limit, LimitResult, Limits, Status, limit_row, with_full
from .predictions import PlacementPrediction, Predictions
from .verdict import INSTRUMENT

NOTHING_HELD_OUT = "no placement was held out; record another and add it by --test"
ONE_SOCKET = "no held-out placement has two sockets, so there is no distance"
NEAREST = 0.1
"""A held-out placement nearer than this to one that was trained on proves nothing [m]."""
SAME_CONFIGURATION, COPIED_SHARE, COMPARED = 1e-3, 0.5, 200
"""Configurations that differ by less on every joint are the same [rad], [m]; a larger share of them
is a copy; and so many configurations of a placement are looked at."""
SIGNIFICANCE = 0.05
"""Probability that the distance errors of a sound calibration are called implausible."""
USUAL_DRIFT = 1e-3
"""Usual size of a drift from the first sample to the last [m]."""
LEAST_FREEDOM = 10
"""Degrees of freedom below which no drift is estimated."""


def held_out(predictions: Predictions) -> tuple[list[str], list[str]]:
    """Return the names of independent held-out placements, and in words why others are not."""
    proving, others = list[str](), list[str]()
    for held in predictions.of_role("test"):
        words = (_trained_already(held, one) for one in predictions.of_role("train"))
        why = next(filter(None, words), "")
        (others if why else proving).append(why or held.name)
    return proving, others


def _trained_already(held: PlacementPrediction, trained: PlacementPrediction) -> str:
    """Return why a held-out placement is not independent of one trained on; empty if it is."""
    rows = held.measured.positions
    rows = rows[:: -(-len(rows) // COMPARED)]
    gaps = abs(rows[:, None] - trained.measured.positions).max(axis=2)
    if np.mean(gaps.min(axis=1) < SAME_CONFIGURATION) > COPIED_SHARE:
        return f"{held.name} is a copy of {trained.name}"
    if held.measured.kind == "points" or trained.measured.kind == "points":
        return ""
    away = float(np.linalg.norm(held.position - trained.position))
    if away >= NEAREST:
        return ""
    return f"{held.name} is at the place of {trained.name}, or a part of it ({mm(away, 0)} away)"


def held_out_rows(predictions: Predictions, limits: Limits) -> list[LimitResult]:
    """Return whether the errors at placements that were not trained on are within their limits."""
    document, (proving, others) = predictions.document, held_out(predictions)
    rows = [row for row in document.placements if row.role == "test" and row.name in proving]
    by_instrument = bool(rows) and all(row.kind == "points" for row in rows)
    loaded = mean_metrics([row.loaded for row in rows]) if rows else None
    full = mean_metrics([row.calibrated for row in rows]) if rows else None
    if document.summary.test is not None and not others:
        loaded, full = document.summary.test.loaded, document.summary.test.calibrated
    full = None if full == loaded else full
    words = f"{joined(others)}, which proves nothing"
    missing = f"{words}; record another {NEAREST:g} m away" if others else NOTHING_HELD_OUT
    proved = [one for one in predictions.of_role("test") if one.name in proving]
    known = _deviations_of(proved, rows)
    found = error_rows(loaded, full, limits, missing, by_instrument=by_instrument, known=known)
    if others:
        status = "warning" if proving else "not evaluated"
        found.append(limit_row("held_out", status, words, text=words))
    return [*found, *_distance_deviations(rows)]


def _deviations_of(
    held: Sequence[PlacementPrediction], rows: Sequence[PlacementErrors]
) -> dict[str, float]:
    """Return the standard deviations of held-out means: of the error, and of the distances [m]."""
    if not held:
        return {}
    errors = np.concatenate([one.errors("geometric") for one in held])
    found = {"mean_absolute_error": float(errors.std() / len(errors) ** 0.5)}
    lengths = [row.distance_deviation for row in rows if row.distance_deviation]
    if lengths:
        found["distance_error"] = float(np.linalg.norm(lengths)) / len(lengths)
    return found


def _distance_deviations(rows: Sequence[PlacementErrors]) -> list[LimitResult]:
    """Return whether the errors of held-out distances agree with their standard deviations."""
    known = [
        (abs(off) / row.distance_deviation, abs(off), row.distance_deviation, row.name)
        for row in rows
        if row.distance_deviation and (off := row.calibrated.distance_error) is not None
    ]
    if not known:
        return []
    name = "distance_deviations"
    allowed = NormalDist().inv_cdf(1 - SIGNIFICANCE / 2 / len(known))
    z, off, deviation, worst = max(known)
    words = f"at most {allowed:.1f} standard deviations"
    if z <= allowed:
        return [limit_row(name, "pass", words, off, allowed * deviation)]
    text = (
        f"at {worst} the sockets come out {mm(off)} from what was said, {z:.1f} standard "
        "deviations: the data cannot tell which base's distance is wrong, or moved between its "
        "sockets, there or where it was trained; measure each again"
    )
    return [limit_row(name, "not enough", text, off, allowed * deviation)]


def error_rows(
    loaded: Metrics | None,
    full: Metrics | None,
    limits: Limits,
    missing: str,
    *,
    by_instrument: bool = False,
    known: Mapping[str, float] = MappingProxyType({}),
) -> list[LimitResult]:
    """Return rows on the errors of ``calibrated.urdf``; ``missing`` says why there are none.

    ``known`` has standard deviations of the errors by the rows' names [m].
    """
    no_distance = missing if loaded is None else INSTRUMENT if by_instrument else ONE_SOCKET
    rows: list[LimitResult] = []
    for name, why in (("mean_absolute_error", missing), ("distance_error", no_distance)):
        by_urdf, by_full = (metrics and getattr(metrics, name) for metrics in (loaded, full))
        limit, deviation = getattr(limits, name), known.get(name, 0.0)
        rows.append(_length_row(name, limit, by_urdf, by_full, why, deviation))
    return rows


def between_row(between: Sequence[KnownDistanceErrors], limit: Limit) -> LimitResult:
    """Return whether distances between placements, measured from outside, come out right."""
    rows = [row for row in between if not row.in_fit]
    missing = "no distance between placements is known; measure one and add it by --known"
    if between:
        missing = "all distances known were used in the fit; add others by --known"
    loaded = fmean(abs(row.errors.loaded) for row in rows) if rows else None
    apart = bool(rows) and rows[0].geometric_error is not None
    full = fmean(abs(row.errors.calibrated) for row in rows) if apart else None
    return _length_row("between_placements", limit, loaded, full, missing)


def _length_row(
    name: str,
    limit: Limit,
    reached: float | None,
    full: float | None,
    missing: str,
    deviation: float = 0.0,
) -> LimitResult:
    """Return whether a limit is kept; it is missed only beyond the figure's own deviation."""
    if reached is None or limit.value is None:
        reason = missing if reached is None else limit.source
        return limit_row(name, "not evaluated", reason, reached, limit.value)
    own = f" (+- {mm(deviation, 3)})" if deviation else ""
    text = f"{TITLES[name]} {mm(reached, 3)}{own}, limit {mm(limit.value, 3)}"
    if full is not None:
        text += f" (with corrected joint positions {mm(full, 3)})"
    status: Status = "fail" if reached > limit.value + deviation else "pass"
    if reached > limit.value and deviation > limit.value:
        status, text = "not enough", f"{text}: record more samples in each socket"
    row = limit_row(
        name, status, limit.source, reached, limit.value, text=text, deviation=deviation or None
    )
    return with_full(row, full, "fail")


def drift_rows(predictions: Predictions, limits: Limits) -> list[LimitResult]:
    """Return whether the ball drifts in any placement, and whether that matters.

    It does where the fit does not model it, and by more than a third of the limit on distances.
    """
    drifts: dict[Role, list[str]] = {"train": [], "test": []}
    modelled = predictions.document.posterior is not None
    limit, largest = limits.mean_absolute_error.value, 0.0
    for placement in predictions.placements:
        measured = placement.measured
        known = modelled and placement.role == "train" and np.isfinite(measured.clock("time")).all()
        if measured.kind == "sockets" and not known:
            evidence, length = steady_drift(placement)
            if evidence > 0:
                drifts[placement.role].append(f"{placement.name} by {mm(length)}")
                largest = max(largest, length if placement.role == "train" else 0.0)
    start = "the ball drifts in its sockets from the first sample to the last, at"
    text = "; ".join(str(d) for d in predictions.document.checks or () if d.code == "movement")
    severe = limit is None or largest > SEVERE * predicted_limit(limit)
    if drifts["train"]:
        text = (
            f"{start} {joined(drifts['train'])}: the data cannot tell a base, a table or a joint "
            "that moved meanwhile from an error of the model; record it again, firmly screwed down"
        )
    status = "not enough" if drifts["train"] and severe else "warning" if text else "pass"
    text = text or "none beyond the scatter"
    rows = [limit_row("drift", status, text, text=text)]
    if drifts["test"]:
        text = f"{start} {joined(drifts['test'])}"
        rows.append(limit_row("drift_held_out", "warning", text, text=text))
    return rows


def steady_drift(placement: PlacementPrediction) -> tuple[float, float]:
    """Return ln B of a placement's drift, and its length over the recording [m]."""
    measured = placement.measured
    t = measured.order / len(measured.order)
    e: np.ndarray = placement.deviations.calibrated.copy()
    weights = np.array([1.0 if s.weight is None else s.weight for s in placement.samples])
    freedom = len(t) - len(measured.sockets) - 3
    for rows in measured.slices:
        w = weights[rows] / weights[rows].sum()
        t[rows] -= w @ t[rows]
        e[rows] -= w @ e[rows]
    along = float(weights @ t**2)
    if freedom < LEAST_FREEDOM or along == 0:
        return 0.0, 0.0
    v: np.ndarray = (weights * t) @ e / along
    left = e - np.outer(t, v)
    scatter: np.ndarray = (weights[:, None] * left).T @ left
    scatter /= weights.sum() - len(measured.sockets) - 1
    V = scatter / along + (1e-3 * USUAL_DRIFT) ** 2 * np.eye(3)  # of exact data, too
    chi2 = float(v @ np.linalg.solve(V + V @ V / USUAL_DRIFT**2, v)) * (freedom - 1) / (freedom + 3)
    spread = np.linalg.slogdet(np.eye(3) + USUAL_DRIFT**2 * np.linalg.inv(V))[1]
    return 0.5 * (chi2 - float(spread)), float(np.linalg.norm(v))
