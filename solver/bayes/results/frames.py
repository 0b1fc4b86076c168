"""Poses of the frames in which positions were measured."""

import numpy as np

from ...data import IDENTITY, WORLD, Places, Pose, as_point
from ...results import FramePose
from ..inference import FitPosterior


def frame_poses(posterior: FitPosterior) -> tuple[FramePose, ...]:
    """Return the frames in which sockets or points were measured, in the robot's base."""
    data = posterior.data
    centres = posterior.state.centres
    poses = [
        frame_pose(
            data,
            k,
            pose,
            posterior.frame_covariance(name),
            centres,
            data.points_in(name),
        )
        for k, (name, pose) in enumerate(posterior.frames.items())
    ]
    if data.anchored:
        poses.append(frame_pose(data, WORLD, IDENTITY, np.zeros((6, 6)), centres, 0))
    return tuple(poses)


def frame_pose(
    places: Places,
    frame: int,
    pose: Pose,
    covariance: np.ndarray,
    centres: np.ndarray,
    points: int,
) -> FramePose:
    """Return a frame with the errors at its sockets.

    Args:
        places: The S sockets, and their coordinates in frames.
        frame: Index of the frame.
        pose: In the base.
        covariance: Of the pose, its turn [rad] first, shape (6, 6).
        centres: Of the sockets in the base, shape (S, 3) [m].
        points: Number of balls that were measured in it.
    """
    deviation = np.sqrt(np.diag(covariance).clip(min=0))
    error = None
    items = [item for item in places.located if item.frame == frame]
    if items:
        coordinates = pose.apply(np.array([item.coordinates for item in items]))
        offsets = centres[[item.socket for item in items]] - coordinates
        error = float(np.sum(offsets**2, axis=1).mean()) ** 0.5
    return FramePose(
        name="base" if frame == WORLD else places.frames[frame],
        xyz=pose.origin.xyz,
        rpy=pose.origin.rpy,
        xyz_deviation=as_point(deviation[3:]),
        turn_deviation=as_point(deviation[:3]),
        sockets=len(items),
        points=points,
        socket_error=error,
    )
