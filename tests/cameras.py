"""A board seen by a camera on an arm or beside it: poses, views, and their columns."""

import numpy as np
from calibrated_arm import pose_at

from mukca import Placement
from mukca.recorder import Sample, read_table_placement
from mukca.solver.calibration import FullModel, quaternion_of
from mukca.solver.identification.data import Pose
from mukca.solver.identification.robot import rotation_matrices, turn

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
MOUNTED = pose_at([0.1, -0.3, 0.4], [0.05, -0.02, 0.08]).matrix
"""Of a camera on the flange, or of a board there."""
STANDING = pose_at([2.8, 0.3, 0.1], [0.5, 0.1, 1.6]).matrix
"""Of a camera beside the arm."""
LYING = pose_at([0.0, 0.0, 0.0], [0.6, 0, -0.2]).matrix
"""Of a board beside the arm."""


def board_seen(flange, camera):
    """Return the board's poses in a camera, on the arm or beside it, shape (N, 4, 4)."""
    if camera == "beside":
        return np.linalg.inv(STANDING) @ flange @ MOUNTED
    return np.linalg.inv(flange @ MOUNTED) @ LYING


def columns_of(poses):
    """Return poses as places [m] and quaternions, shape (N, 7)."""
    return np.hstack([poses[:, :3, 3], quaternion_of(poses[:, :3, :3])])


def flanges(arm, q):
    """Return where the full model of an arm has its flange, shape (N, 4, 4)."""
    return FullModel(arm).flange(q)


def views(simulated, camera, count=15, seed=0, noise=1.0):
    """Return joints and the board's poses in the camera, times 0.2 mm and 0.5 mrad noisy."""
    generator = np.random.default_rng(seed)
    robot = simulated.calibration.robot
    q = simulated.later.positions[:count] + generator.normal(0, 0.1, (count, 7))
    q = np.clip(q, robot.lower, robot.upper)
    board = board_seen(flanges(simulated.truth, q), camera)
    for B in board:
        B[:3, 3] += noise * generator.normal(0, 2e-4, 3)
        B[:3, :3] = turn(noise * generator.normal(0, 5e-4, 3)) @ B[:3, :3]
    return np.hstack([q, columns_of(board)])


def recorded(rows):
    """Return views of seven numbers, as joint positions, and a pose each as a placement."""
    samples = [
        Sample(tuple(r[:-7]), 0, point=tuple(r[-7:-4]), orientation=tuple(r[-4:]))
        for r in rows.tolist()
    ]
    return Placement("views", tuple(samples))


def names_of(simulated):
    """Return the columns of such views."""
    return (*simulated.calibration.robot.joint_names, *POSE)


def rotations(rows):
    """Return the turns of views, shape (N, 3, 3)."""
    return rotation_matrices(rows[:, -4:])


def angles_of(R):
    """Return roll, pitch and yaw of a turn [rad]."""
    return Pose(R, np.zeros(3)).origin.rpy


def in_file(file):
    """Return the views in a file."""
    return read_table_placement(file)
