"""Axes that are fixed to the links of an arm, however the frames of a URDF are drawn."""

import numpy as np

from .chain import across
from .rotations import matrix_rpy
from .urdf import Robot


def link_axes(robot: Robot) -> np.ndarray:
    """Return the axes of the base link and of the joints' child links, in columns, in their frames.

    A link has those of the last joint that moves it: the two about which the joint tilts, and its
    own. The base has its frame's.

    Returns:
        Shape (joints + 1, 3, 3).
    """
    frames = [np.eye(3)]
    for joint, turn in zip(robot.joints, matrix_rpy(robot.origins[:, 3:]), strict=True):
        axes = turn.T @ frames[-1]
        if joint.actuated:
            b, c = joint.tilt_axes or across(joint.axis)
            axes = np.array([b, c, joint.axis]).T
        frames.append(axes)
    return np.array(frames)
