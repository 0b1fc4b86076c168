"""What a calibration was made from."""

from dataclasses import dataclass

from ...solver.checks.inspection import Finding
from ...solver.data.measurements import Measurement
from ...solver.robot.urdf import Robot
from ..documents.calibration import NextPlacement
from .settings import Settings

__all__ = ["Inspected", "Task"]


@dataclass(frozen=True)
class Inspected:
    """What a look at the recordings showed before they were fitted."""

    findings: tuple[Finding, ...]
    next_placement: NextPlacement | None
    """None where an instrument measured all samples."""


@dataclass(frozen=True)
class Task:
    """A robot, checked recordings of it, and how they are to be fitted."""

    robot: Robot
    settings: Settings
    train: tuple[Measurement, ...]
    test: tuple[Measurement, ...]
    warnings: tuple[str, ...]
    inspected: Inspected | None
    """None where the recordings could not be checked."""
