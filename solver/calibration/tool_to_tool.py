"""Distances between the tools of two arms, predicted and measured, at places held out."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..identification.data import Measurement
from ..results import Document
from .multi_robot_calibration import MultiRobotCalibration
from .option import UsageError
from .shared_places import AtPlaces, at_places


class Spread(Document):
    """Absolute errors of distances [m]."""

    mean: float
    p95: float
    """95 % of the errors are below."""
    max: float


class ToolToTool(Document):
    """Errors of predicted distances of two tools, held against measured ones."""

    robots: tuple[str, str]
    samples: tuple[int, int]
    """Samples of each robot at the places that both touched."""
    pairs: int
    """Distances that were compared."""
    loaded: Spread
    """By ``calibrated.urdf`` of both arms, each where ``arms.urdf`` has it."""
    calibrated: Spread
    """With corrected joint positions."""


def tool_distances(
    arms: MultiRobotCalibration, data: Mapping[str, Sequence[Measurement]]
) -> ToolToTool:
    """Compare predicted and measured distances between the tools of two arms.

    Each sample of one arm is taken with each sample of the other at the same place. In one socket
    the tools are at distance 0; in an instrument's frame the coordinates have their distance,
    wherever the instrument stood. The error of a pair is ``| |p - p'| - |x - x'| |`` with predicted
    balls p in the first robot's base, and measured points x.

    Args:
        arms: Robots that were calibrated together.
        data: Checked placements of two of them, which the calibration did not see.

    Raises:
        UsageError: The two share no place, or the recordings do not tell where a base stands.
    """
    first, second = data
    robots = {name: arms[name].calibrated for name in data}
    both = [
        at_places(robot, arms.pose(name), data[name]) for name, robot in robots.items()
    ]
    places = [place for place in both[0] if place in both[1]]
    if not places:
        raise UsageError(
            f"{first} and {second}: nothing is held out at one place; record both arms in the same "
            "sockets (folders of one name), or by one instrument (one frame)"
        )
    urdfs = [
        at_places(robot.geometric, arms.urdf_pose(name), data[name])
        for name, robot in robots.items()
    ]
    errors = _errors(both, places)
    a, b = [sum(len(samples[place]) for place in places) for samples in both]
    return ToolToTool(
        robots=(first, second),
        samples=(a, b),
        pairs=len(errors),
        loaded=_spread(_errors(urdfs, places)),
        calibrated=_spread(errors),
    )


def _errors(
    robots: Sequence[AtPlaces], places: Sequence[tuple[str, int]]
) -> np.ndarray:
    """Return the error of each pair of samples at the same place [m]."""
    errors: list[np.ndarray] = []
    for place in places:
        apart = robots[0][place][:, None] - robots[1][place]
        distances = np.linalg.norm(apart, axis=-1)
        errors.append(np.abs(distances[..., 0] - distances[..., 1]).ravel())
    return np.concatenate(errors)


def _spread(errors: np.ndarray) -> Spread:
    """Return the mean, the 95th percentile and the largest of some errors."""
    p95, largest = np.quantile(errors, [0.95, 1.0]).tolist()
    return Spread(mean=float(errors.mean()), p95=p95, max=largest)
