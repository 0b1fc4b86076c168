"""Errors that placements leave when each is fitted alone, and which of them stand out."""

from collections.abc import Sequence

import numpy as np

from ..data import Measurement
from ..robot import Robot, choose_parameters
from .robust_fit import UNEXPLAINED, RigidModel, samples_of

BAD_RATIO = 2.5
"""A placement is not to be trusted if the fit to it alone leaves this many times the error that is
usual for the others."""
EXACT = 1e-5
"""Largest error that a fit leaves of fewer samples than it has unknowns [m]: it says nothing."""


def fitted_alone(robot: Robot, measurements: Sequence[Measurement]) -> dict[str, float]:
    """Return the error that each placement leaves when fitted alone, by its name [m].

    It is the mean distance of its samples from their socket, each by its weight, by a robust
    rigid fit to nothing but them.
    """
    model = RigidModel(robot, choose_parameters(robot))
    return {m.name: model.fit(samples_of([m])).error for m in measurements}


def standing_out(floors: Sequence[float]) -> list[float | None]:
    """Return, for each placement that stands out, the error that it should leave by the others [m].

    Args:
        floors: Errors that each leaves when fitted alone [m].

    Returns:
        None for each that leaves about as much as the others.
    """
    typical = [_typical([*floors[:i], *floors[i + 1 :]]) for i in range(len(floors))]
    return [
        t if f > BAD_RATIO * max(t, EXACT) else None for f, t in zip(floors, typical, strict=True)
    ]


def _typical(others: Sequence[float]) -> float:
    """Return the error that a placement should leave by the others' [m]; infinity if unknown."""
    typical = float(np.median(others)) if others else np.inf
    if len(others) == 1:
        typical = max(typical, UNEXPLAINED / BAD_RATIO)
    return typical if typical < UNEXPLAINED else np.inf
