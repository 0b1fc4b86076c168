"""The problem of a calibration: a robot, its checked recordings, and the options."""

from dataclasses import dataclass, replace

import numpy as np

from .. import results
from ..identification.data import Measurement
from ..identification.model import set_apart
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
        """Return the recordings with the movements of their places, row by row.

        Where a placement that is held out differs throughout follows from its own samples.
        """
        train = self.measurements
        if shifts is not None:  # orientations come last
            ends = np.cumsum([len(m.positions) for m in train])
            parts = zip(train, np.split(shifts, ends), strict=False)
            train = [replace(m, moved=shift) for m, shift in parts]
        test = [_set_apart(m, calibrated) for m in self.test]
        return replace(self, measurements=tuple(train), test=tuple(test))


def _set_apart(
    measured: Measurement, calibrated: results.CalibratedRobot
) -> Measurement:
    """Return a held-out placement with what is otherwise in it."""
    if not measured.apart:
        return measured
    balls = calibrated.predict(measured)
    return replace(measured, moved=set_apart(calibrated.robot, measured, balls))
