"""Joint positions that a robot cannot have had: units, signs or columns that are wrong."""

import math

import numpy as np

from ...errors import MukcaError
from ...recorder import Placement
from ..robot import Robot

_FAR_OUTSIDE = 1.0
"""Distance from its limits at which a joint cannot have been [rad or m]: the units are wrong."""
_BARELY_OUTSIDE = math.radians(5)


class MeasurementError(MukcaError):
    """A placement does not hold what a calibration needs."""


def check_limits(placement: Placement, robot: Robot, warnings: list[str]) -> None:
    """Refuse joint positions far outside of the limits, and warn of those outside."""
    positions = placement.positions
    lower = np.array([joint.lower for joint in robot.actuated])
    upper = np.array([joint.upper for joint in robot.actuated])
    endless = np.isinf(lower) & np.isinf(upper)
    lower, upper = np.where(endless, -4 * np.pi, lower), np.where(endless, 4 * np.pi, upper)
    positions = positions - _whole_turns(positions, lower, upper, robot)
    excess = np.maximum(lower - positions, positions - upper)
    row, column = np.unravel_index(int(np.argmax(excess)), excess.shape)
    joint = robot.actuated[int(column)]
    where = placement.samples[int(row)].where or placement.name
    text = (
        f"{where}: joint {joint.name!r} at {positions[row, column]:.4g} is outside its limits, "
        f"{lower[column]:.4g} to {upper[column]:.4g} {'m' if joint.type == 'prismatic' else 'rad'}"
    )
    if excess[row, column] > _FAR_OUTSIDE:
        turned = -positions[:, column]
        if np.all((lower[column] <= turned) & (turned <= upper[column])):
            raise MeasurementError(
                f"{text}; all of its column lies inside with the other sign: is it sign-flipped?"
            )
        degrees = "are these degrees? a header of JOINT [deg] is read as such"
        guess = degrees if abs(positions).max() > 2 * np.pi else "is it another robot?"
        raise MeasurementError(
            f"{text}; angles are radians ({guess}), in the order of the chain's joints"
        )
    if excess[row, column] > _BARELY_OUTSIDE:
        warnings.append(text)


def _whole_turns(
    positions: np.ndarray, lower: np.ndarray, upper: np.ndarray, robot: Robot
) -> np.ndarray:
    """Return whole turns of joints without which all of a column is inside its limits [rad]."""
    turns = np.zeros(len(lower))
    for j, joint in enumerate(robot.actuated):
        values, turn = positions[:, j], 2 * math.pi
        away = turn * round(float(values.mean() - (lower[j] + upper[j]) / 2) / turn)
        inside = np.all((lower[j] <= values - away) & (values - away <= upper[j]))
        if joint.type != "prismatic" and abs(away) <= 2 * turn and inside:
            turns[j] = away
    return turns
