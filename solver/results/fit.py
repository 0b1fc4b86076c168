"""The fit of a robot, the same for both methods."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..identification.inference import FitPosterior, Posterior
from .calibrated import CalibratedRobot
from .calibration import FramePose


@dataclass(frozen=True)
class Fit:
    """The result of a fit, the same for both methods."""

    calibrated: CalibratedRobot
    optimizer: str
    seconds: float
    """Duration of the fit [s]."""
    iterates: tuple[CalibratedRobot, ...]
    """The robot after each iteration, the nominal one first."""
    covariance: np.ndarray | None = None
    """By the paper's method: how far the parameters would move if the same were recorded again,
    shape (n, n)."""
    full: FitPosterior | None = None
    """By the default method: the posterior of all unknowns, and why."""
    frames: tuple[FramePose, ...] | None = None
    """Of several robots that were calibrated together: frames in the base of this one, the first;
    None for a robot alone."""

    @cached_property
    def posterior(self) -> Posterior | None:
        """Posterior of the robot; None where it has none, or its covariance is not finite."""
        if self.full is None:
            return None
        posterior = self.full.arm
        return posterior if _is_covariance(posterior.covariance) else None


def _is_covariance(matrix: np.ndarray) -> bool:
    return bool(np.isfinite(matrix).all() and (np.diag(matrix) >= 0).all())
