"""Rows on a steady drift of the ball within its sockets, in the order of recording.

A base that creeps, a table that gives way, or a zero that warms up moves the ball steadily. One
straight line in time is fitted to the ball within the sockets of a placement,

    e_i = v (t_i - mean of t in the socket)

with the errors e by the full model and the number t of the sample, and v, three numbers, is held
against its scatter.
"""

import numpy as np

from .formatting import joined, mm
from .limits import LimitResult, limit_row
from .predictions import PlacementPrediction, Predictions

STEADY = 13.0
"""Chi-squared of three numbers that sound recordings hardly reach: 5 in 1000 by chance."""
LEAST = 10
"""Samples below which nothing is said."""


def drift_rows(predictions: Predictions) -> list[LimitResult]:
    """Return whether the ball drifts in the sockets of any placement, trained on or held out."""
    rows: list[LimitResult] = []
    for role, status, name in (
        ("train", "not enough", "drift"),
        ("test", "warning", "drift_held_out"),
    ):
        placements = [p for p in predictions.of_role(role) if p.measured.kind == "sockets"]
        found = [(p.name, *steady_drift(p)) for p in placements]
        odd = [(place, length) for place, chi2, length in found if chi2 > STEADY]
        title = "steady drift where it was trained" if role == "train" else "steady drift held out"
        if not odd:
            if role == "train" and found:
                rows.append(limit_row(name, title, "pass", "none beyond the scatter"))
            continue
        places = joined([f"{place} by {mm(length)}" for place, length in odd])
        text = f"the ball drifts in its sockets from the first sample to the last, at {places}"
        if role == "train":
            text += (
                ": the data cannot tell a base, a table or a joint that moved meanwhile from an "
                "error of the model; record it again, firmly screwed down"
            )
        rows.append(limit_row(name, title, status, text, text=text))
    return rows


def steady_drift(placement: PlacementPrediction) -> tuple[float, float]:
    """Return chi-squared of a placement's drift, and its length over the recording [m]."""
    measured = placement.measured
    sockets = measured.placement.sockets
    t = np.concatenate([np.flatnonzero(sockets == k) for k in measured.sockets]).astype(float)
    e = placement.deviations.calibrated.copy()
    weights = np.array([1.0 if s.weight is None else s.weight for s in placement.samples])
    span, freedom = float(np.ptp(t)), len(t) - len(measured.sockets) - 3
    for rows in measured.slices:
        w = weights[rows] / weights[rows].sum()
        t[rows] -= w @ t[rows]
        e[rows] -= w @ e[rows]
    along = float(weights @ t**2)
    if freedom < LEAST or along == 0:
        return 0.0, 0.0
    v = (weights * t) @ e / along
    left = e - np.outer(t, v)
    scatter = (weights[:, None] * left).T @ left / (weights.sum() - len(measured.sockets) - 1)
    chi2 = along * float(v @ np.linalg.pinv(scatter) @ v)
    return chi2 * (freedom - 1) / (freedom + 3), span * float(np.linalg.norm(v))
