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
    axes = [np.eye(3)]
    rotations = matrix_rpy(robot.origins[:, 3:])
    for joint, R in zip(robot.joints, rotations, strict=True):
        if joint.actuated:
            b, c = joint.tilt_axes or across(joint.axis)
            own_axes = np.array([b, c, joint.axis]).T
            axes.append(own_axes)
        else:
            axes.append(R.T @ axes[-1])
    return np.array(axes)
