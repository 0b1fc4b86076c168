"""Poses of the frames in which positions were measured."""

import numpy as np

from ...data import IDENTITY, WORLD, Pose, as_point
from ...results import FramePose
from ..inference import FitPosterior


def frame_poses(posterior: FitPosterior) -> tuple[FramePose, ...]:
    """Return the frames in which sockets or points were measured, in the robot's base."""
    data = posterior.data
    frames = {k: (name, posterior.frames[name]) for k, name in enumerate(data.frames)}
    if data.anchored:
        frames[WORLD] = ("base", IDENTITY)
    poses = list[FramePose]()
    for k, (name, pose) in frames.items():
        known = k != WORLD
        covariance = posterior.frame_covariance(name) if known else np.zeros((6, 6))
        items = [item for item in data.located if item.frame == k]
        coordinates = np.reshape([item.coordinates for item in items], (-1, 3))
        centres = posterior.state.centres[[item.socket for item in items]]
        points = int((data.measured_in == k).sum()) if known else 0
        poses.append(frame_pose(name, pose, covariance, centres, coordinates, points))
    return tuple(poses)


def frame_pose(
    name: str,
    pose: Pose,
    covariance: np.ndarray,
    centres: np.ndarray,
    coordinates: np.ndarray,
    points: int,
) -> FramePose:
    """Return a frame with the errors at its K sockets.

    Args:
        name: Of the frame.
        pose: In the base.
        covariance: Of the pose, its turn [rad] first, shape (6, 6).
        centres: Of the sockets with coordinates in it, in the base, shape (K, 3) [m].
        coordinates: Of these in the frame, shape (K, 3) [m].
        points: Number of balls that were measured in it.
    """
    deviation, error = np.sqrt(np.diag(covariance).clip(min=0)), None
    if len(centres):
        offsets = centres - pose.apply(coordinates)
        error = float(np.sum(offsets**2, axis=1).mean()) ** 0.5
    return FramePose(
        name=name,
        xyz=pose.origin.xyz,
        rpy=pose.origin.rpy,
        xyz_deviation=as_point(deviation[3:]),
        turn_deviation=as_point(deviation[:3]),
        sockets=len(centres),
        points=points,
        socket_error=error,
    )
