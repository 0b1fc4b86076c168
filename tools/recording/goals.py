"""Goals of a recording session: errors that a calibrated arm of a kind keeps within."""

from ...solver import assessment, diagnostics
from ...solver.identification.robot import Robot

GOAL = 3.0
"""Ratio of the limit on held-out errors to the arm's repeatability."""


def goal_for(robot: Robot) -> float:
    """Return the goal of the predicted error of distances [m], before anything is solved."""
    return diagnostics.predicted_limit(limit_for(robot))


def limit_for(robot: Robot) -> float:
    """Return the limit on held-out errors [m]: three times the arm's repeatability.

    At least as many times the resolution of a printed socket.
    """
    name = assessment.known_arm(robot)
    resolution = assessment.RESOLUTION
    return GOAL * max(
        assessment.ARMS[name].repeatability if name else resolution, resolution
    )
