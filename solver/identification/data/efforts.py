"""Measured joint efforts, held against the gravity torque of the model's masses.

At rest a joint exerts on the arm what gravity asks of it: tau(q) by the model, e as measured. Of
joints that carry something, over all samples, the slope s and the correlation r are

    s = sum(tau e) / sum(tau^2)    r = sum(tau e) / sqrt(sum(tau^2) sum(e^2))

A clear correlation with a slope far from 1 shows another sign or unit. No correlation shows
nothing: a hand may have held the arm.
"""

import math
from dataclasses import replace

import numpy as np

from ....recorder import Placement
from ..robot import Robot, gravity_moments
from .measurements import Load

CLEAR = 0.9
"""Correlation beyond which efforts are the gravity torque, by some factor."""
LEAST_SLOPE, LARGEST_SLOPE = 0.2, 5.0
"""Slopes that a payload or a rough model may explain."""
CARRIES = 1.0
"""Typical gravity torque of a joint that counts [N m]."""
ENOUGH = 8
"""Fewest samples that show it."""


def with_plausible_efforts(placement: Placement, robot: Robot, load: Load) -> Placement:
    """Return a placement without efforts that contradict the model, and a remark that says so."""
    efforts = placement.efforts
    q = placement.positions
    if efforts is None or len(q) < ENOUGH or robot.masses_assumed:
        return placement
    moments = gravity_moments(robot, q, load.gravity, load.payload)
    tau = moments[:, : q.shape[1]]
    loaded = np.sqrt(np.mean(tau**2, axis=0)) > CARRIES
    tau = tau[:, loaded]
    e = efforts[:, loaded]
    square = float(np.sum(tau**2))
    square_of_efforts = float(np.sum(e**2))
    if square * square_of_efforts == 0:
        return placement
    product = float(np.sum(tau * e))
    slope = product / square
    correlation = product / math.sqrt(square * square_of_efforts)
    if abs(correlation) < CLEAR or LEAST_SLOPE < slope < LARGEST_SLOPE:
        return placement
    reason = "are they in N m"
    if -LARGEST_SLOPE < slope < 0:
        reason = (
            "is their sign turned (option `effort` of the driver), "
            "or does the arm hang (--gravity)"
        )
    remark = (
        f"{placement.where}: efforts are {slope:.3g} times the model's gravity torque "
        f"(correlation {correlation:.3f}); {reason}? The model's torque takes their place"
    )
    samples = tuple(replace(sample, effort=None) for sample in placement.samples)
    return replace(placement, samples=samples, remarks=(*placement.remarks, remark))
