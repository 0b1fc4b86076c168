"""Distance between two calibrations of one arm, beside that which chance alone would bring."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ...errors import MukcaError
from ..identification.data import Load, Measurement
from ..identification.inference import Posterior
from ..identification.robot import workspace
from ..results import Apart
from ..studies import Estimate, apart_by_chance
from .calibration import Calibration

POSES = 120
"""Poses at which two calibrations are compared at most."""


@dataclass(frozen=True)
class Comparison:
    """Two fits of one arm, to be compared by the load that it carries."""

    first: Posterior
    second: Posterior
    load: Load
    later: bool = False
    """True if one began where the other ended."""

    def at(self, measured: Measurement | None) -> Apart:
        """Return how far they are apart at the samples of a placement; None for random poses."""
        robot = self.first.model.robot
        q, efforts = workspace(robot, POSES), None
        if measured is not None:
            q, efforts = measured.positions, measured.efforts
        step = -(-len(q) // POSES)
        samples = self.load.at(robot, q, efforts)
        poses = samples.only(slice(None, None, step))
        a, b = Estimate(self.first, poses), Estimate(self.second, poses)
        return apart_by_chance(a, b, follows=self.later)


def differences(
    a: Calibration, b: Calibration, data: Sequence[Measurement]
) -> tuple[Apart | None, tuple[Apart | None, ...]]:
    """Return how far two calibrations are apart, in the workspace and at placements.

    A calibration by the paper's method has no covariance, so nothing is known of chance.
    """
    nothing = None, (None,) * len(data)
    if a.document.posterior is None or b.document.posterior is None:
        return nothing
    is_later = is_prior_of(a, b) or is_prior_of(b, a)
    try:
        pair = Comparison(a.posterior, b.posterior, a.load, is_later)
    except MukcaError:  # what it began from is not at hand any more
        return nothing
    return pair.at(None), tuple(map(pair.at, data))


def is_prior_of(first: Calibration, second: Calibration) -> bool:
    """Tell whether one calibration began where another ended (``--prior``)."""
    prior = second.document.settings.get("prior")
    file = Path(first.source).resolve()
    return prior is not None and Path(prior).resolve() in (file, file.parent)
