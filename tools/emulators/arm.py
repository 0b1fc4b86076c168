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


def emulated_arm(
    joints: int,
    rate: float,
    motion: tuple[float, float],
    noise: float,
    folder: Path | None = None,
) -> SimulatedArm:
    """Return an arm that goes through a placement's configurations, or again and again through 40.

    The poses and the efforts that are no placement's are invented; the efforts are no arm's gravity
    torque.

    Args:
        joints: Number of the robot's joints.
        rate: States per second.
        motion: Duration of each rest and each move [s].
        noise: Standard deviation of the encoder noise [rad].
        folder: The placement; none for poses of its own.

    Raises:
        MukcaError: The placement cannot be read, or is another robot's.
    """
    poses, efforts = _invented(joints) if folder is None else _recorded(folder, joints)
    hold, move = motion
    path = Motion(poses, hold=hold, move=move)
    return SimulatedArm(path, efforts=efforts, rate=rate, noise=noise)


def _recorded(folder: Path, joints: int) -> tuple[list[list[float]], list[list[float]] | None]:
    placement = read_placement(folder)
    poses: list[list[float]] = placement.positions.tolist()
    if len(poses[0]) != joints:
        raise MukcaError(
            f"{folder}: {len(poses[0])} joints, but this controller's arm has {joints}"
        )
    return poses, None if placement.efforts is None else placement.efforts.tolist()


def _invented(joints: int) -> tuple[list[list[float]], list[list[float]]]:
    source = random.Random(joints)  # noqa: S311 - poses, no secret
    middle = [ELBOW if joint % 2 else 0.0 for joint in range(joints)]
    poses = [[q + source.uniform(-SPREAD, SPREAD) for q in middle] for _ in range(POSES)]
    efforts = [[GREATEST_EFFORT * math.sin(q) for q in pose] for pose in poses]
    return poses * ROUNDS, efforts * ROUNDS
