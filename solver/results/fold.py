"""A fold: a fit that leaves out some samples, whose errors then prove the fit to all."""

from dataclasses import dataclass

from ..identification.data import Measurement
from .calibrated import CalibratedRobot
from .fit import Fit


@dataclass(frozen=True)
class Fold:
    """A whole fit to all but some samples, and these."""

    fit: Fit
    ball: CalibratedRobot | None
    """The nominal robot, its ball refitted to the samples of the fit; None if not identified."""
    trained: tuple[Measurement, ...]
    left_out: tuple[Measurement, ...]
    """Placements, or parts of them."""
