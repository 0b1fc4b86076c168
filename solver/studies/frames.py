"""Poses of the frames in which positions were measured."""

import numpy as np

from ..identification.data import IDENTITY, WORLD, Places, Pose, as_point
from ..results import Fit, FramePose, Measurements, Study, rms


def frames(
    fit: Fit,
    _: Measurements,
) -> tuple[FramePose, ...] | None:
    """Return the frames in which sockets or points were measured, in the robot's base.

    Those of several robots are results of the first.
    """
    posterior = fit.full
    assert posterior is not None
    if fit.frames is not None:
        return fit.frames or None
    data = posterior.data
    centres = posterior.state.centres
    poses: list[FramePose] = []
    for k, (name, pose) in enumerate(posterior.frames.items()):
        covariance = posterior.frame_covariance(name)
        points = data.points_in(name)
        poses.append(frame_pose(data, k, pose, covariance, centres, points))
    if data.anchored:
        exact = np.zeros((6, 6))
        poses.append(frame_pose(data, WORLD, IDENTITY, exact, centres, points=0))
    return tuple(poses) or None


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
        coordinates = np.array([item.coordinates for item in items])
        seats = centres[[item.socket for item in items]]
        error = rms(np.linalg.norm(seats - pose.apply(coordinates), axis=1))
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


FRAMES = Study("frames", frames)
