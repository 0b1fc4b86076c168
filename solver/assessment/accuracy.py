"""Rows on how well an arm is known: predicted errors of distances, its size, its joints' travel."""

import math
from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from ..diagnostics import predicted_limit
from ..poses import InverseKinematics
from ..results import (
    Better,
    DistanceDeviation,
    Improvement,
    Interval,
    Scale,
    Uncertainty,
)
from .error_words import interval_text, short_mm
from .formatting import joined, mm
from .limits import (
    NEAR,
    TITLES,
    WORKSPACE,
    Limit,
    LimitResult,
    error_limit,
    limit_row,
)
from .predictions import Coverage, Predictions, travels

WELL_TURNED = math.radians(60)
"""A joint that turned less is named where too little is known [rad]."""
LENGTH_TOLERANCE = 1e-3
"""Links are machined, and a socket base is measured, to this share of their length: no predicted
distance has to be known better."""
SIZE_DEVIATION = 5e-3
"""The paper's method must know an arm's size to this share of it, so that a distance of the sockets
that is 1 % wrong is seen. With 30 samples in each socket it knows it to 0.1 to 0.3 %."""
LEAST_TRAVEL = math.radians(20)
"""A joint that turned less than this over all that was trained on is hardly seen [rad]."""
LEAST_FREEDOM = 0.01
"""Share of a joint's motion that the ball in its socket allows; an arm of five joints in a plane
cannot turn its first one."""


def allowance(limit: float, length: float | None) -> tuple[float, str]:
    """Return what a predicted error may come to, by the limit on held-out errors [m], and why.

    No distance has to be known better than to 0.1 % of the median ``length`` of distances [m].
    """
    allowed = predicted_limit(limit)
    if length is not None and LENGTH_TOLERANCE * length > allowed:
        reason = f"{100 * LENGTH_TOLERANCE:g} % of {mm(length)}, their median length"
        return LENGTH_TOLERANCE * length, reason
    times = f"{allowed / limit:.2g} times " if allowed > limit else ""
    return allowed, f"{times}the limit on the measured error"


def predicted_in_words(
    predicted: Interval, length: float | None, repeatability: float | None
) -> str:
    """Return a predicted error of distances [m], and whether it asks for another placement.

    The allowance is that of the verdict on a calibration, so that all say the same.
    """
    words = (
        f"a distance anywhere in the workspace would be wrong by about {short_mm(predicted.value)} "
        f"mm ({interval_text(predicted)})"
    )
    limit = error_limit(repeatability)
    if limit is None:
        return f"{words}; whether that is enough follows from your arm's --repeatability-mm"
    allowed, _ = allowance(limit, length)
    high = short_mm(predicted.high)
    if predicted.high > allowed:
        return (
            f"{words}; {high} mm would be more than this arm's limit, {mm(allowed)}, "
            "so record another placement"
        )
    return (
        f"{words}; even {high} mm would be within this arm's limit, {mm(allowed)}, "
        "so no other placement is needed"
    )


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
    everywhere = better and better.workspace
    near = better and better.recorded_places
    rows: list[LimitResult] = []
    if uncertainty.near is not None:
        rows.append(_predicted_row(NEAR, uncertainty.near, near, limit, coverage))
    rows.append(
        _predicted_row(
            WORKSPACE, uncertainty.distance_deviation, everywhere, limit, coverage
        )
    )
    return rows


def _predicted_row(
    name: str,
    predicted: DistanceDeviation,
    improvement: Improvement | None,
    limit: Limit,
    coverage: Coverage,
) -> LimitResult:
    """Return whether the upper end of the 68 % interval of an error is within its limit.

    Older files have a standard deviation in its place.
    """
    if improvement is not None:
        now, corrected = improvement.now, improvement.corrected
    elif predicted.alone is not None:
        now, corrected = _exactly(predicted.alone), _exactly(predicted.median)
    else:
        now, corrected = _exactly(predicted.median), None
    if limit.value is None:
        return limit_row(name, "not evaluated", limit.source, now.value)
    allowed, reason = allowance(limit.value, predicted.length)
    is_kept = now.high <= allowed
    text = f"{TITLES[name]} are wrong by {mm(now.value)}"
    if now.low < now.high:
        text += f" ({interval_text(now)})"
        reason += f"; {interval_text(now)} mm"
    text += f", and {mm(allowed)} is allowed"
    if not is_kept:
        text += f"; record more varied samples{_least_travel(coverage)}"
        trained = {s.placement for s in coverage.sockets if s.role == "train"}
        single = ", and a second placement far from the first"
        several = ", and another placement far from the others"
        text += several if len(trained) > 1 else single
    status = "pass" if is_kept else "not enough"
    row = limit_row(name, status, reason, now.value, allowed, text=text)
    row = replace(row, interval=now if improvement else None)
    if corrected is None:
        return row
    by_full_model = "pass" if corrected.high <= allowed else "not enough"
    return replace(row, full=corrected.value, full_status=by_full_model)


def _exactly(error: float) -> Interval:
    return Interval(value=error, low=error, high=error)


def size_known_row(scale: Scale | None, coverage: Coverage) -> LimitResult:
    """Return whether the paper's method, which predicts no errors, knows the arm's size."""
    deviation = scale and scale.deviation
    if deviation is None or deviation <= SIZE_DEVIATION:
        return limit_row(
            "known",
            "warning",
            "the paper's method does not say how well it knows; --method auto does",
        )
    text = (
        f"the arm's size is known to {100 * deviation:.1f} % only, and a wrong distance of the "
        f"sockets could hide in that; record more varied samples{_least_travel(coverage)}, with "
        "sockets farther apart, or use --method auto"
    )
    return limit_row("known", "not enough", text)


def _least_travel(coverage: Coverage) -> str:
    """Return the joint that turned least, in words; empty where all turned well."""
    travel = travels(coverage)
    joint = min(travel, key=travel.__getitem__, default="")
    if not joint or travel[joint] >= WELL_TURNED:
        return ""
    return f" ({joint} turned by {math.degrees(travel[joint]):.0f} deg only)"


def joints_held(predictions: Predictions) -> list[str]:
    """Return the joints that a ball in its socket lets not move, whatever the others do.

    With J the ball's derivatives, shape (3, m), the ball stays for motions in the null space of J;
    joint i is free by the share 1 - (J^+ J)_ii.
    """
    measured = [placement.measured for placement in predictions.placements]
    q = [m.positions for m in measured if m.kind == "sockets"]
    if not q:
        return []
    guide = InverseKinematics(predictions.robot)
    J = guide.ball_and_neck(np.concatenate(q))[1][:, :3]
    inverses = np.linalg.pinv(J, rcond=1e-3)
    freedoms = 1 - np.median(np.einsum("nij,nji->ni", inverses, J), axis=0)
    pairs = zip(predictions.robot.joint_names, freedoms, strict=True)
    return [name for name, freedom in pairs if freedom < LEAST_FREEDOM]


def travel_row(coverage: Coverage, held: Sequence[str] = ()) -> LimitResult:
    """Return whether each joint turned enough, but those that a socket holds."""
    turned = travels(coverage)
    turned = {name: travel for name, travel in turned.items() if name not in held}
    still = [name for name, travel in turned.items() if travel < LEAST_TRAVEL]
    smallest = math.degrees(min(turned.values(), default=0.0))
    if not still:
        words = f"each joint turned {smallest:.0f} deg or more"
        return limit_row("travel", "pass", words)
    text = (
        f"{joined(still)} turned by {smallest:.0f} deg or little more; record samples in which "
        f"each joint turns by {math.degrees(LEAST_TRAVEL):.0f} deg at least, better 90"
    )
    return limit_row("travel", "not enough", text)
