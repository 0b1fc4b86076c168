"""The frames of a calibration as figures: where each stands, and how well that is known."""

import numpy as np

from ...solver.auto.posterior import World
from ...solver.data.frames import Pose
from ...solver.data.known import WORLD, Located
from ...solver.robot.joined import rpy_of
from ..documents.calibration import FramePose

__all__ = ["frame_poses"]


def frame_poses(world: World) -> tuple[FramePose, ...]:
    """Return the frames in which sockets or points were measured, in the first robot's base."""
    names = list(world.frames)
    located = world.scene.arms[0].located
    poses = [
        _frame(world, name, [one for one in located if one.frame == k])
        for k, name in enumerate(names)
        if k not in world.scene.bases
    ]
    anchored = [one for one in located if one.frame == WORLD]
    if anchored:
        poses.append(_base(world, anchored))
    return tuple(poses)


def _frame(world: World, name: str, located: list[Located]) -> FramePose:
    pose, deviation = world.frames[name], np.sqrt(np.diag(world.frame_covariance(name)).clip(min=0))
    k = list(world.frames).index(name)
    measured = [arm.instrument for arm in world.scene.arms if arm.instrument is not None]
    return FramePose(
        name=name,
        xyz=_three(pose.translation),
        rpy=rpy_of(pose.rotation),
        xyz_deviation=_three(deviation[3:]),
        turn_deviation=_three(deviation[:3]),
        sockets=len(located),
        points=sum(int((one.frames == k).sum()) for one in measured),
        socket_error=_error(world, pose, located),
    )


def _base(world: World, located: list[Located]) -> FramePose:
    """Return the base of the first robot, in which coordinates of sockets are known."""
    zero = (0.0, 0.0, 0.0)
    pose = Pose(np.eye(3), np.zeros(3))
    return FramePose(
        name="base",
        xyz=zero,
        rpy=zero,
        xyz_deviation=zero,
        turn_deviation=zero,
        sockets=len(located),
        points=0,
        socket_error=_error(world, pose, located),
    )


def _error(world: World, pose: Pose, located: list[Located]) -> float | None:
    """Return how far sockets are from their coordinates, a root mean square [m]."""
    if not located:
        return None
    centres = world.arms[0].centres  # the first robot's base is the world
    places = pose.apply(np.array([one.coordinates for one in located]))
    off = centres[[one.socket for one in located]] - places
    squares: np.ndarray = np.sum(off**2, axis=1)
    return float(squares.mean()) ** 0.5


def _three(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
