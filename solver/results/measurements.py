"""Measurements of a robot that a calibration is made of, and others that it is held against."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..identification.data import Measurement, RobotRecordings
from ..identification.inference import Posterior
from .fit import Fit
from .fold import Fold
from .placements import Role

Unseen = tuple[Posterior, Sequence[Measurement]]
"""Placements, or parts of them, with the posterior of a fit that has not seen them."""


@dataclass(frozen=True, kw_only=True)
class Measurements(RobotRecordings):
    """A robot, its placements to train on, and those that are held out."""

    name: str = ""
    """Its name among several robots; empty for one alone."""
    test: Sequence[Measurement] = ()
    """Placements that the fit does not see."""
    folds: Sequence[Fold] = ()
    """Where nothing is held out: fits that each leave out some samples."""

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

    def unseen(self, fit: Fit) -> list[Unseen]:
        """Return what fits did not see: held out of the fit itself, or left out by its folds."""
        pairs = [(fit.posterior, self.test)] if self.test else []
        pairs += [(fold.fit.posterior, fold.left_out) for fold in self.folds]
        return [
            (posterior, placements)
            for posterior, placements in pairs
            if posterior is not None
        ]
