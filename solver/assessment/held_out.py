"""Rows of the verdict on held-out placements and on known distances.

What is judged is ``calibrated.urdf``, since that is what a user loads. Where the full model, which
corrects joint positions first, is another, its figures stand beside. The error alone can be driven
to zero by a model that shrinks the robot to a point, so the distance stands beside it; but for
coordinates that an instrument measured, which tell size as well.
"""

from collections.abc import Sequence

import msgspec

from ..results import Summary
from .formatting import mm
from .known_distances import KnownDistanceErrors
from .limits import Limit, LimitResult, Limits, limit_row
from .predictions import ModelName
from .verdict import INSTRUMENT

NOTHING_HELD_OUT = "no placement was held out; record another and add it by --test"
ONE_SOCKET = "no held-out placement has two sockets, so there is no distance"


def held_out_rows(
    held_out: Summary | None, limits: Limits, *, by_instrument: bool = False
) -> list[LimitResult]:
    """Return whether the errors at placements that were not trained on are within their limits.

    Args:
        held_out: Errors there; None without any.
        limits: What is allowed.
        by_instrument: Whether all that was held out are points that an instrument measured.
    """
    loaded = None if held_out is None else held_out.loaded
    full = None if held_out is None or held_out.geometric is None else held_out.calibrated
    return [
        _length_row(
            "mean_absolute_error",
            "held-out error (MAE)",
            limits.mean_absolute_error,
            None if loaded is None else loaded.mean_absolute_error,
            None if full is None else full.mean_absolute_error,
            NOTHING_HELD_OUT,
        ),
        _length_row(
            "distance_error",
            "held-out distance error",
            limits.distance_error,
            None if loaded is None else loaded.distance_error,
            None if full is None else full.distance_error,
            NOTHING_HELD_OUT if loaded is None else INSTRUMENT if by_instrument else ONE_SOCKET,
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
