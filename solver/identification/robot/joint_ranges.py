"""Limits of joints, and joint positions all over an arm's workspace."""

from dataclasses import replace

import numpy as np

from .chain import Joint
from .urdf import Robot


def one_turn(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Return the limits of all joints, within -180 to 180 degrees: a hand guides no farther."""
    lower = np.maximum(robot.lower, -np.pi)
    upper = np.minimum(robot.upper, np.pi)
    return lower, upper


def reaching(robot: Robot, positions: np.ndarray) -> Robot:
    """Return the robot whose limits hold joint positions, too, shape (N, m) [rad]."""
    columns = dict(zip(robot.joint_names, positions.T.tolist(), strict=True))
    joints: list[Joint] = []
    for joint in robot.joints:
        ends = [joint.lower, joint.upper, *columns.get(joint.name, ())]
        joints.append(replace(joint, lower=min(ends), upper=max(ends)))
    return replace(robot, joints=tuple(joints))


def workspace(
    robot: Robot,
    count: int,
    seed: int = 0,
) -> np.ndarray:
    """Return random joint positions within the joints' limits, shape (count, m) [rad].

    Joints that turn farther stay within -180 to 180 degrees.
    """
    lower, upper = one_turn(robot)
    generator = np.random.default_rng(seed)
    return generator.uniform(lower, upper, (count, len(lower)))
