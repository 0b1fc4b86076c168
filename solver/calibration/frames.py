"""The frames of a calibration as figures: where each stands, and how well that is known.

Of several robots, also how they stood, and which sockets they visited.
"""

import casadi as ca
import numpy as np

from ..bayes.inference import JointPosterior
from ..data import IDENTITY, WORLD, Located, Pose
from ..results import FramePose, VisitedSocket
from ..robot import link_frames
from .multi_robot_urdf import rpy_of


def frame_poses(world: JointPosterior) -> tuple[FramePose, ...]:
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


def _frame(world: JointPosterior, name: str, located: list[Located]) -> FramePose:
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


def _base(world: JointPosterior, located: list[Located]) -> FramePose:
    """Return the base of the first robot, in which coordinates of sockets are known."""
    zero = (0.0, 0.0, 0.0)
    return FramePose(
        name="base",
        xyz=zero,
        rpy=zero,
        xyz_deviation=zero,
        turn_deviation=zero,
        sockets=len(located),
        points=0,
        socket_error=_error(world, IDENTITY, located),
    )


def _error(world: JointPosterior, pose: Pose, located: list[Located]) -> float | None:
    """Return how far sockets are from their coordinates, a root mean square [m]."""
    if not located:
        return None
    centres = world.arms[0].centres  # the first robot's base is the world
    places = pose.apply(np.array([one.coordinates for one in located]))
    off = centres[[one.socket for one in located]] - places
    squares: np.ndarray = np.sum(off**2, axis=1)
    return float(squares.mean()) ** 0.5


def visited_sockets(world: JointPosterior) -> tuple[VisitedSocket, ...]:
    """Return all sockets in the first robot's base, and which robots were there."""
    data = world.scene.arms[0]
    visitors = [
        tuple(
            name
            for name, arm in zip(world.scene.names, world.scene.arms, strict=True)
            if k in arm.sockets
        )
        for k in range(data.socket_count)
    ]
    places = zip(data.labels, world.arms[0].centres, visitors, strict=True)
    return tuple(
        VisitedSocket(name=f"{placement}:{socket}", xyz=_three(centre), robots=robots)
        for (placement, socket), centre, robots in places
    )


def postures(world: JointPosterior, robot: int) -> list[list[list[float]]]:
    """Return how a robot stood at each base that it shares, in the base of the first robot.

    Returns:
        Places of its joints, shape (bases, joints + 1, 3) [m].
    """
    arm, data, base = world.arms[robot], world.scene.arms[robot], world.scene.bases[robot]
    pose = IDENTITY if base == WORLD else list(world.frames.values())[base]
    others = [o.sockets for i, o in enumerate(world.scene.arms) if i != robot]
    shared = np.isin(data.sockets, np.concatenate(others)) & (data.sockets >= 0)
    shared_sockets: list[int] = np.unique(data.sockets[shared]).tolist()
    first = {data.labels[k][0]: k for k in reversed(shared_sockets)}
    origins = ca.DM(arm.model.ball.origins(arm.values).ravel())
    places: list[list[list[float]]] = []
    for socket in first.values():
        row = int(np.argmax(data.sockets == socket))
        frames = link_frames(arm.model.robot.joints, origins, ca.DM(data.positions[row]))
        joints = np.array([np.zeros(3), *(np.array(ca.DM(p)).ravel() for _, p in frames)])
        places.append(pose.apply(joints).round(5).tolist())
    return places


def _three(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
