"""Rows on drifts: the ball creeps in its sockets from a placement's first sample to its last."""

from collections.abc import Mapping

import numpy as np

from ..diagnostics import SEVERE, predicted_limit
from ..results import Role
from .formatting import joined, mm, short_where
from .limits import LimitResult, Limits, Status, is_dwarfed, limit_row
from .predictions import PlacementPrediction, Predictions

USUAL_DRIFT = 1e-3
"""Usual size of a drift from the first sample to the last [m]."""
LEAST_FREEDOM = 10
"""Degrees of freedom below which no drift is estimated."""


def drift_rows(predictions: Predictions, limits: Limits) -> list[LimitResult]:
    """Return whether the ball drifts in any placement, and whether that matters.

    It does where the fit does not model it, by more than a third of the limit on distances, and
    unless the calibration gains more.
    """
    trained, tested = drifts_of(predictions, "train"), drifts_of(predictions, "test")
    limit, largest = limits.mean_absolute_error.value, max(trained.values(), default=0)
    start = "the ball drifts in its sockets from the first sample to the last, at"
    checks = predictions.document.checks or ()
    places = {short_where(d.where): "" for d in checks if d.code == "movement"}
    status: Status = "warning" if trained or places else "pass"
    text = "none beyond the scatter"
    if trained:
        is_severe = limit is None or largest > SEVERE * predicted_limit(limit)
        if is_severe and not is_dwarfed(predictions.document.better, largest, largest):
            status = "not enough"
        text = (
            f"{start} {_sizes(trained)}: a base, a table or a joint that moved meanwhile looks "
            "like an error of the model in these data; record it again, firmly screwed down"
        )
    elif places:
        text = f"something moved at {joined(list(places))}"
    rows = [limit_row("drift", status, text, text=text)]
    if tested:
        text = f"{start} {_sizes(tested)}"
        rows.append(limit_row("drift_held_out", "warning", text, text=text))
    return rows


def drifts_of(predictions: Predictions, role: Role) -> dict[str, float]:
    """Return the length of each drift that the fit does not model [m], by its placement's name."""
    drifts: dict[str, float] = {}
    document = predictions.document
    weighs = document.posterior and not document.settings.get("as_recorded")
    for placement in () if role == "train" and weighs else predictions.of_role(role):
        if placement.measured.kind == "sockets":
            evidence, length = steady_drift(placement)
            if evidence > 0:
                drifts[placement.name] = length
    return drifts


def _sizes(drifts: Mapping[str, float]) -> str:
    return joined([f"{name} by {mm(length)}" for name, length in drifts.items()])


def steady_drift(placement: PlacementPrediction) -> tuple[float, float]:
    """Return ln B of a placement's drift, and its length over the recording [m]."""
    measured = placement.measured
    t = measured.order / len(measured.order)
    e: np.ndarray = placement.deviations.calibrated.copy()
    weights = np.array(
        [1.0 if s.weight is None else s.weight for s in placement.samples]
    )
    for rows in measured.slices:
        t[rows] -= np.average(t[rows], weights=weights[rows])
        e[rows] -= np.average(e[rows], axis=0, weights=weights[rows])
    freedom = len(t) - len(measured.sockets) - 3
    along = float(weights @ t**2)
    if freedom < LEAST_FREEDOM or along == 0:
        return 0.0, 0.0
    v: np.ndarray = (weights * t) @ e / along
    residuals = e - np.outer(t, v)
    scatter: np.ndarray = (weights[:, None] * residuals).T @ residuals
    scatter /= weights.sum() - len(measured.sockets) - 1
    V = scatter / along + (1e-3 * USUAL_DRIFT) ** 2 * np.eye(3)  # of exact data, too
    chi2 = (
        float(v @ np.linalg.solve(V + V @ V / USUAL_DRIFT**2, v))
        * (freedom - 1)
        / (freedom + 3)
    )
    spread = np.linalg.slogdet(np.eye(3) + USUAL_DRIFT**2 * np.linalg.inv(V))[1]
    return 0.5 * (chi2 - float(spread)), float(np.linalg.norm(v))
