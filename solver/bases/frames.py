"""Poses of the frames in which positions were measured, in the base of the first robot."""

from ..bayes.results import frame_pose
from ..data import WORLD
from ..results import FramePose
from .ties import TiedRobots


def frames_of_robots(world: TiedRobots) -> tuple[FramePose, ...]:
    """Return the frames but bases; that of the first robot where coordinates are known in it."""
    places = world.places
    bases = {robot.frame for robot in world.robots}
    frames = [k for k in range(len(places.frames)) if k not in bases]
    if any(item.frame == WORLD for item in places.located):
        frames.append(WORLD)
    poses = list[FramePose]()
    for k in frames:
        name = "" if k == WORLD else places.frames[k]
        points = sum(arm.data.points_in(name) for arm in world.arms)
        covariance = world.frame_covariance(k)
        poses.append(frame_pose(places, k, world.poses[k], covariance, world.centres, points))
    return tuple(poses)
