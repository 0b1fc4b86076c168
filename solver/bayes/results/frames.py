"""Poses of the frames in which positions were measured."""

import numpy as np

from ...data import IDENTITY, WORLD, Pose, as_point
from ...results import FramePose
from ..inference import JointPosterior


def frame_poses(world: JointPosterior) -> tuple[FramePose, ...]:
    """Return the frames in which sockets or points were measured, in the first robot's base."""
    poses = [
        _frame_pose(world, k, name, pose, world.frame_covariance(name))
        for k, (name, pose) in enumerate(world.frames.items())
        if k not in world.scene.bases
    ]
    if any(socket.frame == WORLD for socket in world.scene.arms[0].located):
        poses.append(_frame_pose(world, WORLD, "base", IDENTITY, np.zeros((6, 6))))
    return tuple(poses)


def _frame_pose(
    world: JointPosterior, k: int, name: str, pose: Pose, covariance: np.ndarray
) -> FramePose:
    """Return a frame by its index, its name, its pose and the covariance of that."""
    deviation = np.sqrt(np.diag(covariance).clip(min=0))
    sockets = [socket for socket in world.scene.arms[0].located if socket.frame == k]
    error = None
    if sockets:
        places = pose.apply(np.array([socket.coordinates for socket in sockets]))
        # the first robot's base is the world
        offsets = world.arms[0].centres[[socket.socket for socket in sockets]] - places
        error = float(np.sum(offsets**2, axis=1).mean()) ** 0.5
    return FramePose(
        name=name,
        xyz=pose.origin.xyz,
        rpy=pose.origin.rpy,
        xyz_deviation=as_point(deviation[3:]),
        turn_deviation=as_point(deviation[:3]),
        sockets=len(sockets),
        points=sum(int((arm.measured_in == k).sum()) for arm in world.scene.arms if k != WORLD),
        socket_error=error,
    )
