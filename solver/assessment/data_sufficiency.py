"""Sufficiency of the data for a verdict: samples, travel, and a small predicted error.

A few samples, or many alike, leave small errors by any model, so small errors are then no proof.
"""

import math
from collections.abc import Sequence

from ..diagnostics import Diagnostic
from ..results import Scale, Uncertainty
from .coverage import Coverage
from .formatting import joined, mm, plural
from .limits import Limit, LimitResult, Status, limit_row
from .predictions import PlacementPrediction

LEAST_SAMPLES = 10
"""In each of two sockets: with fewer, the sockets' centres and the noise are hardly known."""
LEAST_HELD_OUT = 5
"""In each of two sockets held out: with fewer, the mean lies with the samples."""
LEAST_TRAVEL = math.radians(20)
"""A joint that turned less than this over all that was trained on is hardly seen [rad]."""
WELL_TURNED = math.radians(60)
"""A joint that turned less is named where too little is known [rad]."""
LINKS = 1e-3
"""Links are machined, and a base of 50 mm is measured, to this share of their length. No distance
is asked to be known better, which a large arm would need to be."""
SIZE = 5e-3
"""The paper's method must know an arm's size to this share of it, so that a distance of the sockets
that is 1 % wrong is seen. With 30 samples in each socket it knows it to 0.1 to 0.3 %."""
PREDICTED, ANY_ARM = 3.0, 2e-3
"""The predicted error of distances may be this many times the limit on held-out errors, since
nothing at one placement shows the far workspace: a good recording of an arm that repeats to 0.1 mm
comes to 1 to 2.4 times. That is no more than some 1.2 mm with any arm, so arms that repeat worse
may have up to this much [m], or the limit itself."""

BESIDE = ("far", "duplicate", "few", "still")
"""Codes of warnings that do not bear on the model: single samples that hardly count, and amounts
that rows of their own judge."""


def checks_row(checks: Sequence[Diagnostic] | None) -> LimitResult:
    """Return the row of the data checks: no PASS beside an error, or what bears on the model."""
    name, title = "data_checks", "data checks"
    if checks is None:
        words = "the calibration holds no checks of the recordings; run mukca check"
        return limit_row(name, title, "not evaluated", words)
    errors = sum(check.level == "error" for check in checks)
    warnings = [check for check in checks if check.level == "warning"]
    reason = f"{plural(errors, 'error')} and {plural(len(warnings), 'warning')} in the recordings"
    open_ = [f"{one.text}; {one.advice}" for one in warnings if one.code not in BESIDE]
    if errors or not open_:
        return limit_row(name, title, "fail" if errors else "pass", reason)
    return limit_row(name, title, "not enough", reason, text="; ".join(dict.fromkeys(open_)))


def samples_row(placements: Sequence[PlacementPrediction], *, tied: bool) -> LimitResult:
    """Return whether enough samples lie in each socket.

    Args:
        placements: All of the calibration.
        tied: Distances between placements were given to the fit, so that two sockets of any count.
    """
    points = points_row(placements)
    if points is not None:
        return points
    trained = [p.measured.counts for p in placements if p.role == "train"]
    held_out = [p.measured.counts for p in placements if p.role == "test"]
    if tied:
        trained = [tuple(n for counts in trained for n in counts)]
    few = _second(trained)
    text = f"{plural(few, 'sample')} or more in each socket trained on"
    enough: Status = "pass"
    if few < LEAST_SAMPLES:
        enough = "not enough"
        text = (
            f"only {plural(few, 'sample')} in a socket trained on; record at least "
            f"{LEAST_SAMPLES} in each, better 30"
        )
    elif held_out and _second(held_out) < LEAST_HELD_OUT:
        enough = "not enough"
        text = (
            f"only {plural(_second(held_out), 'sample')} in a socket held out; record at least "
            f"{LEAST_HELD_OUT} in each, better 30"
        )
    return limit_row("samples", "samples in each socket", enough, text)


def points_row(placements: Sequence[PlacementPrediction]) -> LimitResult | None:
    """Return whether an instrument measured enough points; None where sockets were trained on."""
    counts: dict[str, int] = {"train": 0, "test": 0}
    for one in placements:
        if one.role == "train" and one.measured.kind == "sockets":
            return None
        counts[one.role] += sum(one.measured.counts)
    fewest: dict[str, int] = {"train": 2 * LEAST_SAMPLES, "test": 2 * LEAST_HELD_OUT}
    few = next((role for role in counts if 0 < counts[role] < fewest[role]), None)
    if few is None:
        text = f"{plural(counts['train'], 'measured point')} trained on"
        return limit_row("samples", "measured points", "pass", text)
    part = "trained on" if few == "train" else "held out"
    text = f"only {plural(counts[few], 'measured point')} {part}; measure {fewest[few]} or more"
    return limit_row("samples", "measured points", "not enough", text)


def _second(sockets: Sequence[tuple[int, ...]]) -> int:
    """Return how many samples two sockets of some placement have, at the best placement."""
    return max((sorted(counts)[-2] if len(counts) > 1 else 0 for counts in sockets), default=0)


def travels(coverage: Coverage) -> dict[str, float]:
    """Return how far each joint that turns did over all that was trained on, by its name [rad]."""
    trained = [socket for socket in coverage.sockets if socket.role == "train"]
    return {
        joint.name: max(s.high[i] for s in trained) - min(s.low[i] for s in trained)
        for i, joint in enumerate(coverage.joints)
        if joint.unit == "rad" and trained
    }


def travel_row(coverage: Coverage) -> LimitResult:
    """Return whether each joint that turns was turned enough while recording."""
    turned = travels(coverage)
    still = [name for name, travel in turned.items() if travel < LEAST_TRAVEL]
    least = math.degrees(min(turned.values(), default=0.0))
    if not still:
        return limit_row(
            "travel", "travel of each joint", "pass", f"each joint turned {least:.0f} deg or more"
        )
    text = (
        f"{joined(still)} turned by {least:.0f} deg or little more; record samples in which each "
        f"joint turns by {math.degrees(LEAST_TRAVEL):.0f} deg at least, better 90"
    )
    return limit_row("travel", "travel of each joint", "not enough", text)


def prediction_row(
    uncertainty: Uncertainty | None,
    limit: Limit,
    method: str,
    coverage: Coverage,
    scale: Scale | None = None,
) -> LimitResult:
    """Return whether the error that is predicted of distances is small beside the limit.

    Args:
        uncertainty: How well the calibration is known; None where that could not be computed.
        limit: On the held-out error.
        method: ``paper`` or ``auto``.
        coverage: How far each joint turned.
        scale: Of the arm, all that the paper's method knows of its own errors.
    """
    title = "predicted error of distances"
    if uncertainty is None and method == "paper":
        return _paper_row(title, scale, coverage)
    if uncertainty is None:
        words = "how well the calibration is known could not be computed; record more samples"
        return limit_row("predicted_distance", title, "fail", words)
    predicted = uncertainty.distance_deviation.median
    if limit.value is None:
        return limit_row("predicted_distance", title, "not evaluated", limit.source, predicted)
    allowed = max(limit.value, min(PREDICTED * limit.value, ANY_ARM))
    words = f"{allowed / limit.value:.2g} times the limit on the held-out error"
    length = uncertainty.distance_deviation.length
    if length is not None and LINKS * length > allowed:
        allowed = LINKS * length
        words = f"{100 * LINKS:g} % of {mm(length)}, the median distance in the workspace"
    if predicted <= allowed:
        return limit_row("predicted_distance", title, "pass", words, predicted, allowed)
    text = (
        f"distances in the workspace are known to {mm(predicted)} only, where {mm(allowed)} is "
        f"asked; record more varied samples{_turned_least(coverage)}, and a second placement far "
        "from the first"
    )
    return limit_row("predicted_distance", title, "not enough", text, predicted, allowed)


def _paper_row(title: str, scale: Scale | None, coverage: Coverage) -> LimitResult:
    """Return whether the paper's method knows at least the arm's size."""
    deviation = scale.deviation if scale is not None else None
    if deviation is None or deviation <= SIZE:
        words = "the paper's method does not say how well it knows; --method auto does"
        return limit_row("predicted_distance", title, "not evaluated", words)
    text = (
        f"the arm's size is known to {100 * deviation:.1f} % only, and a wrong distance of the "
        f"sockets could hide in that; record more varied samples{_turned_least(coverage)}, with "
        "sockets farther apart, or use --method auto"
    )
    return limit_row("predicted_distance", title, "not enough", text)


def _turned_least(coverage: Coverage) -> str:
    """Return which joint turned least, where that was little."""
    turned = travels(coverage)
    name = min(turned, key=lambda joint: turned[joint], default="")
    if not name or turned[name] >= WELL_TURNED:
        return ""
    return f" ({name} turned by {math.degrees(turned[name]):.0f} deg only)"
