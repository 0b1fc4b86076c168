"""Rows on a steady drift of the ball within its sockets, in the order of recording.

A base that creeps, a table that gives way, or a zero that warms up moves the ball steadily. One
straight line in time is fitted to the ball within the sockets of a placement,

    e_i = v (t_i - mean of t in the socket)

with the errors e by the full model and the number t of the sample, and v, three numbers, is held
against its scatter.
"""

import numpy as np

from ..results import Role
from .formatting import joined, mm
from .limits import LimitResult, limit_row
from .predictions import PlacementPrediction, Predictions

STEADY = 14.0
"""Chi-squared of three numbers that sound recordings hardly reach: 3 in 1000 by chance."""
LEAST = 10
"""Samples below which nothing is said."""


def drift_rows(predictions: Predictions) -> list[LimitResult]:
    """Return whether the ball drifts in the sockets of any placement, trained on or held out."""
    drifts: dict[Role, list[str]] = {"train": [], "test": []}
    for placement in predictions.placements:
        if placement.measured.kind == "sockets":
            chi2, length = steady_drift(placement)
            if chi2 > STEADY:
                drifts[placement.role].append(f"{placement.name} by {mm(length)}")
    title = "steady drift where it was trained"
    start = "the ball drifts in its sockets from the first sample to the last, at"
    rows = [limit_row("drift", title, "pass", "none beyond the scatter")]
    found = [d for d in predictions.document.checks or () if d.code == "movement"]
    if found:
        text = "; ".join(map(str, found))
        rows = [limit_row("drift", title, "not enough", text, text=text)]
    elif drifts["train"]:
        text = (
            f"{start} {joined(drifts['train'])}: the data cannot tell a base, a table or a joint "
            "that moved meanwhile from an error of the model; record it again, firmly screwed down"
        )
        rows = [limit_row("drift", title, "not enough", text)]
    if drifts["test"]:
        text = f"{start} {joined(drifts['test'])}"
        rows.append(
            limit_row("drift_held_out", "steady drift held out", "warning", text, text=text)
        )
    return rows


def steady_drift(placement: PlacementPrediction) -> tuple[float, float]:
    """Return chi-squared of a placement's drift, and its length over the recording [m]."""
    measured = placement.measured
    sockets = measured.placement.sockets
    t = np.concatenate([np.flatnonzero(sockets == k) for k in measured.sockets]).astype(float)
    e: np.ndarray = placement.deviations.calibrated.copy()
    weights = np.array([1.0 if s.weight is None else s.weight for s in placement.samples])
    span, freedom = float(np.ptp(t)), len(t) - len(measured.sockets) - 3
    for rows in measured.slices:
        w = weights[rows] / weights[rows].sum()
        t[rows] -= w @ t[rows]
        e[rows] -= w @ e[rows]
    along = float(weights @ t**2)
    if freedom < LEAST or along == 0:
        return 0.0, 0.0
    v: np.ndarray = (weights * t) @ e / along
    left = e - np.outer(t, v)
    scatter: np.ndarray = (
        (weights[:, None] * left).T @ left / (weights.sum() - len(measured.sockets) - 1)
    )
    across: np.ndarray = np.linalg.lstsq(scatter, v, rcond=None)[0]
    chi2 = along * float(v @ across)
    return chi2 * (freedom - 1) / (freedom + 3), span * float(np.linalg.norm(v))
