"""The problem of a calibration: a robot, its checked recordings, and the options."""

from dataclasses import dataclass, replace

import numpy as np

from .. import results
from .options import SolveOptions


@dataclass(frozen=True, kw_only=True)
class CalibrationProblem(results.Measurements):
    """A robot, checked recordings of it, and the options of their fit."""

    options: SolveOptions
    warnings: tuple[str, ...] = ()
    checks: tuple[results.Diagnostic, ...] = ()
    """Diagnostics of the recordings, from before the fit."""
    hypotheses: tuple[results.Hypothesis, ...] = ()
    """Explanations of the recordings, the most probable first."""
    next_placement: results.NextPlacement | None = None
    """None where an instrument measured all samples."""

    def at_rest(
        self, shifts: np.ndarray | None, calibrated: results.CalibratedRobot
    ) -> "CalibrationProblem":
        """Return the recordings with what differs between their places, row by row."""
        if shifts is None:
            return self
        ends = np.cumsum([len(m.positions) for m in self.measurements])
        # orientations come last
        parts = zip(self.measurements, np.split(shifts, ends), strict=False)
        train = tuple(replace(m, moved=shift) for m, shift in parts)
        return replace(self, measurements=train)
