"""Rows on a steady drift of the ball within its sockets, in the order of recording.

A base that creeps, a table that gives way, or a zero that warms up moves the ball steadily. Where
the samples hold their order, the fit weighs that itself. Elsewhere, and of what was held out, one
straight line in time is fitted to the ball within the sockets of a placement,

    e_i = v (t_i - mean of t in the socket)          t from 0 at the first sample to 1 at the last

with the errors e by the full model. With V the covariance of v by its scatter, and v within s a
priori, the evidence of a drift over none is, as in the fit,

    ln B = v^T (V + V V / s^2)^-1 v / 2 - ln det(1 + s^2 V^-1) / 2

and a drift is said where that is for it.
"""

import numpy as np

from ..results import Role
from .formatting import joined, mm
from .limits import LimitResult, limit_row
from .predictions import PlacementPrediction, Predictions

USUAL = 1e-3
"""Usual size of a drift from the first sample to the last [m]."""
LEAST = 10
"""Samples below which nothing is said."""


def drift_rows(predictions: Predictions) -> list[LimitResult]:
    """Return whether the ball drifts in the sockets of any placement, trained on or held out."""
    drifts: dict[Role, list[str]] = {"train": [], "test": []}
    weighed = predictions.document.posterior is not None
    for placement in predictions.placements:
        measured = placement.measured
        known = weighed and placement.role == "train" and np.isfinite(measured.clock("time")).all()
        if measured.kind == "sockets" and not known:
            evidence, length = steady_drift(placement)
            if evidence > 0:
                drifts[placement.role].append(f"{placement.name} by {mm(length)}")
    start = "the ball drifts in its sockets from the first sample to the last, at"
    rows = [limit_row("drift", "pass", "none beyond the scatter")]
    found = [d for d in predictions.document.checks or () if d.code == "movement"]
    if found:
        text = "; ".join(map(str, found))
        rows = [limit_row("drift", "not enough", text, text=text)]
    elif drifts["train"]:
        text = (
            f"{start} {joined(drifts['train'])}: the data cannot tell a base, a table or a joint "
            "that moved meanwhile from an error of the model; record it again, firmly screwed down"
        )
        rows = [limit_row("drift", "not enough", text)]
    if drifts["test"]:
        text = f"{start} {joined(drifts['test'])}"
        rows.append(limit_row("drift_held_out", "warning", text, text=text))
    return rows


def steady_drift(placement: PlacementPrediction) -> tuple[float, float]:
    """Return ln B of a placement's drift, and its length over the recording [m]."""
    measured = placement.measured
    sockets = measured.placement.sockets
    t = np.concatenate([np.flatnonzero(sockets == k) for k in measured.sockets]) / len(sockets)
    e: np.ndarray = placement.deviations.calibrated.copy()
    weights = np.array([1.0 if s.weight is None else s.weight for s in placement.samples])
    freedom = len(t) - len(measured.sockets) - 3
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
    V = scatter / along + (1e-3 * USUAL) ** 2 * np.eye(3)  # of exact data, too
    chi2 = float(v @ np.linalg.solve(V + V @ V / USUAL**2, v)) * (freedom - 1) / (freedom + 3)
    spread = np.linalg.slogdet(np.eye(3) + USUAL**2 * np.linalg.inv(V))[1]
    return 0.5 * (chi2 - float(spread)), float(np.linalg.norm(v))
