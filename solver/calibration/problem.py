"""What a calibration was made from."""

from dataclasses import dataclass

from ..data import Measurement
from ..diagnostics import Diagnostic
from ..results import NextPlacement
from ..robot import Robot
from .options import SolveOptions


@dataclass(frozen=True)
class Inspected:
    """What a look at the recordings showed before they were fitted."""

    findings: tuple[Diagnostic, ...]
    next_placement: NextPlacement | None
    """None where an instrument measured all samples."""


@dataclass(frozen=True)
class CalibrationProblem:
    """A robot, checked recordings of it, and how they are to be fitted."""

    robot: Robot
    settings: SolveOptions
    train: tuple[Measurement, ...]
    test: tuple[Measurement, ...]
    warnings: tuple[str, ...]
    inspected: Inspected | None
    """None where the recordings could not be checked."""
