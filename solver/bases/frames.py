"""Poses of the frames in which positions were measured, in the base of the first robot."""

import numpy as np

from ..bayes.results import frame_pose
from ..data import WORLD
from ..results import FramePose
from .ties import TiedRobots


def frames_of_robots(world: TiedRobots) -> tuple[FramePose, ...]:
    """Return the frames but bases; that of the first robot where coordinates are known in it."""
    bases, centres = world.bases(), world.centres()
    frames = {k: name for k, name in enumerate(world.places.frames) if k not in bases}
    if any(item.frame == WORLD for item in world.places.located):
        frames[WORLD] = "base"
    poses = list[FramePose]()
    for k, name in frames.items():
        items = [item for item in world.places.located if item.frame == k]
        coordinates = np.reshape([item.coordinates for item in items], (-1, 3))
        places = np.reshape([centres[item.socket] for item in items], (-1, 3))
        poses.append(
            frame_pose(
                name,
                world.pose(k),
                world.frame_covariance(k),
                places,
                coordinates,
                _points(world, name),
            )
        )
    return tuple(poses)


def _points(world: TiedRobots, name: str) -> int:
    """Return how many balls of all robots were measured in a frame."""
    count = 0
    for arm in world.arms:
        frames = arm.data.frames
        if name in frames:
            count += int((arm.data.measured_in == frames.index(name)).sum())
    return count
