"""Rows on the predicted error of distances: near the recorded places, and in the whole workspace.

What is loaded is the URDF alone. Where the full model is another, how far the two are apart is part
of what the URDF alone is off by, and the figure of the full model stands beside.
"""

import math

import msgspec

from ..results import DistanceDeviation, Scale, Uncertainty
from .coverage import Coverage, travels
from .formatting import mm
from .limits import Limit, LimitResult, limit_row, predicted_limit
from .verdict import NEAR, WORKSPACE

WELL_TURNED = math.radians(60)
"""A joint that turned less is named where too little is known [rad]."""
LINKS = 1e-3
"""Links are machined, and a base of 50 mm is measured, to this share of their length. No distance
is asked to be known better, which a large arm would need to be."""
SIZE = 5e-3
"""The paper's method must know an arm's size to this share of it, so that a distance of the sockets
that is 1 % wrong is seen. With 30 samples in each socket it knows it to 0.1 to 0.3 %."""
PLACES = {NEAR: "distances near the recorded places", WORKSPACE: "distances in the workspace"}


def accuracy_rows(
    uncertainty: Uncertainty | None, limit: Limit, coverage: Coverage
) -> list[LimitResult]:
    """Return whether the errors that are predicted of distances are small beside the limit."""
    if uncertainty is None:
        words = "how well the calibration is known could not be computed; record more samples"
        return [limit_row(WORKSPACE, PLACES[WORKSPACE], "fail", words)]
    near = [] if uncertainty.near is None else [_row(NEAR, uncertainty.near, limit, coverage)]
    return [*near, _row(WORKSPACE, uncertainty.distance_deviation, limit, coverage)]


def _row(name: str, predicted: DistanceDeviation, limit: Limit, coverage: Coverage) -> LimitResult:
    title = PLACES[name]
    found = predicted.median if predicted.alone is None else predicted.alone
    if limit.value is None:
        return limit_row(name, title, "not evaluated", limit.source, found)
    allowed = predicted_limit(limit.value)
    words = f"{allowed / limit.value:.2g} times the limit on the held-out error"
    if predicted.length is not None and LINKS * predicted.length > allowed:
        allowed = LINKS * predicted.length
        words = f"{100 * LINKS:g} % of {mm(predicted.length)}, their median length"
    row = limit_row(name, title, "pass", words, found, allowed)
    if found > allowed:
        text = (
            f"{title} are known to {mm(found)} only, where {mm(allowed)} is asked; record more "
            f"varied samples{_turned_least(coverage)}, and a second placement far from the first"
        )
        row = limit_row(name, title, "not enough", text, found, allowed)
    if predicted.alone is None:
        return row
    by_full = "pass" if predicted.median <= allowed else "not enough"
    return msgspec.structs.replace(row, full=predicted.median, full_status=by_full)


def size_known_row(scale: Scale | None, coverage: Coverage) -> LimitResult:
    """Return whether the paper's method, which predicts no errors, knows the arm's size."""
    title = PLACES[WORKSPACE]
    deviation = scale.deviation if scale is not None else None
    if deviation is None or deviation <= SIZE:
        words = "the paper's method does not say how well it knows; --method auto does"
        return limit_row(WORKSPACE, title, "not evaluated", words)
    text = (
        f"the arm's size is known to {100 * deviation:.1f} % only, and a wrong distance of the "
        f"sockets could hide in that; record more varied samples{_turned_least(coverage)}, with "
        "sockets farther apart, or use --method auto"
    )
    return limit_row(WORKSPACE, title, "not enough", text)


def _turned_least(coverage: Coverage) -> str:
    """Return which joint turned least, where that was little."""
    turned = travels(coverage)
    name = min(turned, key=lambda joint: turned[joint], default="")
    if not name or turned[name] >= WELL_TURNED:
        return ""
    return f" ({name} turned by {math.degrees(turned[name]):.0f} deg only)"
