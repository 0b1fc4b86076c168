"""Two robots in one world: where one's base and tool stand seen from the other's."""

from dataclasses import dataclass

import numpy as np

from ...data import IDENTITY, Pose
from ...robot import workspace
from ..inference import JointPosterior

UNSEEN = 0.1
"""A turn whose standard deviation is larger than this counts as unknown [rad]."""
MARGIN = 0.02
"""The shared region reaches this far beyond the places that both robots visited [m]."""
TRIES = 3000
MEETINGS = 150
STEPS = 12


@dataclass(frozen=True)
class RelativeBasePose:
    """Pose of the second of two robots in the base of the first."""

    names: tuple[str, str]
    pose: Pose
    """Of the second base in the first."""
    covariance: np.ndarray
    """Of its turn about the first base's axes [rad], then its place [m], shape (6, 6)."""
    shared: int
    """Sockets that both visited."""
    tools: float | None
    """Root mean square error of where the second tool stands seen from the first, as predicted,
    over places that both reach about the shared sockets [m]; None where none is."""

    @property
    def unseen(self) -> np.ndarray | None:
        """The axis about which the second robot may be turned, shape (3,); None where none is."""
        values, vectors = np.linalg.eigh(self.covariance[:3, :3])
        return vectors[:, -1] if values[-1] > UNSEEN**2 else None


def between(world: JointPosterior, robot: int) -> RelativeBasePose:
    """Return where a robot stands seen from the first one."""
    name = world.scene.names[robot]
    frame = list(world.frames)[world.scene.bases[robot]]
    visited = [set(arm.sockets[arm.sockets >= 0].tolist()) for arm in world.scene.arms]
    return RelativeBasePose(
        (world.scene.names[0], name),
        world.frames[frame],
        world.frame_covariance(frame),
        len(visited[0] & visited[robot]),
        _tool_deviation(world, robot, frame, sorted(visited[0] & visited[robot])),
    )


def _tool_deviation(
    world: JointPosterior, robot: int, frame: str, shared: list[int]
) -> float | None:
    """Return the error of the distance vector of two tools that meet, as predicted [m]."""
    pose = world.frames[frame]
    region = world.arms[0].centres[shared] if shared else _recorded_by_both(world, robot, pose)
    first, places = _inside(world, 0, IDENTITY, region)
    second, others = _inside(world, robot, pose, region)
    if not len(first) or not len(second):
        return None
    nearest = np.argmin(np.linalg.norm(places[:, None] - others, axis=2), axis=1)
    q, met = _reach(world, robot, pose, second[nearest], places)
    if not met.any():
        return None
    _, by_first, _ = _linear(world, 0, first[met])
    points, by_second, _ = _linear(world, robot, q[met])
    own, begin = world.own, world.own[-1].stop + 6 * list(world.frames).index(frame)
    slopes = np.zeros((int(met.sum()), 3, len(world.covariance)))
    slopes[:, :, own[0]] = -by_first
    slopes[:, :, own[robot]] = pose.rotation @ by_second
    slopes[:, :, begin : begin + 6] = pose.slopes(points)
    squares: np.ndarray = np.sum((slopes @ world.covariance) * slopes, axis=(1, 2))
    return max(float(squares.mean()), 0.0) ** 0.5


def _recorded_by_both(world: JointPosterior, robot: int, pose: Pose) -> np.ndarray:
    """Return corners of the region in the world where both recorded, or between where each did."""
    balls = [
        at.apply(_linear(world, i, world.scene.arms[i].positions)[0])
        for i, at in ((0, IDENTITY), (robot, pose))
    ]
    least, most = (np.array([end(b, axis=0) for b in balls]) for end in (np.min, np.max))
    return np.array([least.max(axis=0), most.min(axis=0)])


def _linear(
    world: JointPosterior, robot: int, q: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    arm = world.arms[robot]
    return arm.model.linearise(arm.x, q, np.tile(0 * q, 3))


def _inside(
    world: JointPosterior, robot: int, pose: Pose, region: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return random configurations whose ball is in the region, and the balls in the world."""
    q = workspace(world.arms[robot].model.robot, TRIES, robot)
    places = pose.apply(world.arms[robot].predict(q, np.tile(0 * q, 3)))
    low, high = region.min(axis=0) - MARGIN, region.max(axis=0) + MARGIN
    inside = ((places > low) & (places < high)).all(axis=1)
    return q[inside][:MEETINGS], places[inside][:MEETINGS]


def _reach(
    world: JointPosterior, robot: int, pose: Pose, q: np.ndarray, places: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return configurations that bring the ball to places (Gauss-Newton), and a mask of success."""
    for _ in range(STEPS):
        points, _, by_joints = _linear(world, robot, q)
        off = places - pose.apply(points)
        q = q + np.einsum("nij,nj->ni", np.linalg.pinv(pose.rotation @ by_joints, rcond=1e-3), off)
    points, _, _ = _linear(world, robot, q)
    return q, np.linalg.norm(places - pose.apply(points), axis=1) < 1e-6
