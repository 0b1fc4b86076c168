"""The arm that an emulated controller moves: through a recording, or through poses of its own."""

import math
import random
from pathlib import Path

from ...drivers.arms import Motion, SimulatedArm
from ...errors import MukcaError
from ...recorder import read_placement

POSES = 40
ROUNDS = 1000  # a motion has an end; at 2 s a pose this one lasts for a day
SPREAD = 0.6  # rad, to each side of the middle
ELBOW = -1.2  # rad: a middle that is not straight
GREATEST_EFFORT = 30.0  # N m


def replay_arm(
    folder: Path, joints: int, rate: float, motion: tuple[float, float], noise: float
) -> SimulatedArm:
    """Return an arm that goes through the configurations of a placement's folder, then rests.

    Args:
        folder: The placement.
        joints: Number of the robot's joints.
        rate: States per second.
        motion: Duration of each rest and each move [s].
        noise: Standard deviation of the encoder noise [rad].

    Raises:
        MukcaError: The placement cannot be read, or is another robot's.
    """
    placement = read_placement(folder)
    configurations = placement.positions.tolist()
    if len(configurations[0]) != joints:
        raise MukcaError(
            f"{folder}: {len(configurations[0])} joints, but this controller's arm has {joints}"
        )
    efforts = None if placement.efforts is None else placement.efforts.tolist()
    hold, move = motion
    path = Motion(configurations, hold=hold, move=move)
    return SimulatedArm(path, efforts=efforts, rate=rate, noise=noise)


def wandering_arm(
    joints: int, rate: float, motion: tuple[float, float], noise: float
) -> SimulatedArm:
    """Return an arm that goes through the same poses again and again.

    The poses and the efforts there are invented; the efforts are no arm's gravity torque.
    """
    source = random.Random(joints)  # noqa: S311 - poses, no secret
    middle = [ELBOW if joint % 2 else 0.0 for joint in range(joints)]
    poses = [[q + source.uniform(-SPREAD, SPREAD) for q in middle] for _ in range(POSES)]
    efforts = [[GREATEST_EFFORT * math.sin(q) for q in pose] for pose in poses]
    hold, move = motion
    path = Motion(poses * ROUNDS, hold=hold, move=move)
    return SimulatedArm(path, efforts=efforts * ROUNDS, rate=rate, noise=noise)
