"""Measurements of a robot that a calibration is made of, and others that it is held against."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..identification.data import Measurement, RobotRecordings
from .placements import Role


@dataclass(frozen=True, kw_only=True)
class Measurements(RobotRecordings):
    """A robot, its placements to train on, and those that are held out."""

    name: str = ""
    """Its name among several robots; empty for one alone."""
    test: Sequence[Measurement] = ()
    """Placements that the fit does not see."""

    @property
    def base_frame(self) -> str:
        """The name of the frame that is the robot's base."""
        return f"{self.name}:base" if self.name else "base"

    @property
    def placements(self) -> list[tuple[Role, Measurement]]:
        """All placements, those to train on first."""
        return [
            *(("train", m) for m in self.measurements),
            *(("test", m) for m in self.test),
        ]

    @property
    def held_out_in_sockets(self) -> list[Measurement]:
        """The placements in sockets that are held out."""
        return [m for m in self.test if m.kind == "sockets"]
