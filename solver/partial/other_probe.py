"""Points that were measured with another probe or tool than the calibration's."""

from collections.abc import Sequence

import numpy as np

from ..assessment import mm
from ..calibration import Calibration
from ..identification.data import Measurement, TipSamples, evaluate, tip_shift

SHARE = 0.5
"""Share of the errors that a shift leaves at most, if it is the cause."""


def probe_shift(calibration: Calibration, data: Sequence[Measurement]) -> float | None:
    """Return how far the tip sits from the ball of the calibration [m]; None for the same tip.

    Any shift counts that explains the errors: a target is put on anew from day to day.
    """
    calibrated, shifts = calibration.calibrated, list[float]()
    for measured in data:
        if measured.kind != "points" or calibration.was_trained_on(measured):
            continue
        points, rotations = calibrated.predict(measured), calibrated.rotations(measured)
        shift = tip_shift([TipSamples(points, rotations, measured.points)])
        before = evaluate(points, measured).mean_absolute_error
        after = evaluate(points + rotations @ shift, measured).mean_absolute_error
        size = float(np.linalg.norm(shift))
        if after < SHARE * before:
            shifts.append(size)
    return max(shifts, default=None)


def probe_words(shift: float | None) -> str:
    """Return a sentence on a tip that was refitted; empty for the same tip."""
    if shift is None:
        return ""
    return f" The tip was refitted: it sits {mm(shift)} from the calibration's."
