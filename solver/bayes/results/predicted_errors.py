"""Predicted errors of distances: in the workspace, near recorded places, between two robots."""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np
from msgspec.structs import replace

from ...data import IDENTITY, Load, Pose, as_point
from ...results import UNSEEN, BaseToBase, DistanceDeviation
from ...robot import PoseModel, PoseSolver, workspace
from ..inference import JointPosterior, Posterior
from .postures import poses_near
from .uncertainty import distance_deviations

WITHIN_ONE, LARGE_GAP = 0.6827, 4.0
"""Share within a deviation; and deviations from which on a gap counts from one side only."""
NEAR, NEARBY = 0.06, 60
"""Standard deviation per axis of a place near a recorded one [m], and how many are thought of."""
MARGIN = 0.02
"""The shared region reaches this far beyond the places that both robots visited [m]."""
TRIES = 3000
MEETINGS = 150


def likely_errors(gap: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return what 68 % of the errors gap + deviation z do not exceed in size, shape (N,) [m]."""
    phi, ratios = NormalDist().cdf, np.linspace(0, LARGE_GAP, 31)
    low, high = ratios.copy(), ratios + 1
    for _ in range(20):
        middle = (low + high) / 2
        pairs = zip(middle.tolist(), ratios.tolist(), strict=True)
        within = np.array([phi(w - r) - phi(-w - r) for w, r in pairs]) > WITHIN_ONE
        low, high = np.where(within, low, middle), np.where(within, middle, high)
    ratio = np.abs(gap) / deviation
    beyond = np.maximum(ratio - LARGE_GAP, 0)
    return deviation * (np.interp(ratio, ratios, high) + beyond)


def predicted_errors(
    posterior: Posterior, load: Load, q: np.ndarray, exported: np.ndarray | None = None
) -> DistanceDeviation:
    """Return the predicted errors of distances between pairs of poses."""
    torque = load.moments(posterior.model.robot, q, None)
    distances, deviation = distance_deviations(posterior, q, torque)
    export_errors = None
    if exported is not None:
        points = posterior.model.ball.points(exported, q)
        gap = np.linalg.norm(points[1::2] - points[::2], axis=1) - distances
        export_errors = float(np.median(likely_errors(gap, deviation)))
    return DistanceDeviation(
        median=float(np.median(deviation)),
        worst=float(deviation.max()),
        length=float(np.median(distances)),
        alone=export_errors,
    )


def workspace_errors(
    posterior: Posterior, load: Load, exported: np.ndarray | None = None, pairs: int = 200
) -> DistanceDeviation:
    """Return the predicted errors of distances between random poses."""
    q = workspace(posterior.model.robot, 2 * pairs)
    return predicted_errors(posterior, load, q, exported)


def errors_near(
    posterior: Posterior,
    load: Load,
    recorded: Sequence[np.ndarray],
    exported: np.ndarray | None = None,
) -> DistanceDeviation | None:
    """Return the predicted errors of distances near recorded places, where they are largest.

    Near is some 0.1 m from a place, in configurations like those recorded there; both ends of a
    distance are near one place. Each placement has joint positions of shape (N, m) [rad].
    """
    deviations: list[DistanceDeviation] = []
    for rows in recorded:
        q, _ = poses_near(posterior.model.robot, rows, (NEARBY, 1), NEAR)
        if len(q) > 1:
            even = q[: len(q) // 2 * 2]
            deviations.append(predicted_errors(posterior, load, even, exported))
    return max(deviations, key=lambda deviation: deviation.alone or deviation.median, default=None)


def between(world: JointPosterior, robot: int) -> BaseToBase:
    """Return where a robot stands seen from the first one; no numbers where a turn is left."""
    names = world.scene.names[0], world.scene.names[robot]
    frame = list(world.frames)[world.scene.bases[robot]]
    visited = [set(arm.sockets[arm.sockets >= 0].tolist()) for arm in world.scene.arms]
    shared = sorted(visited[0] & visited[robot])
    origin, covariance = world.frames[frame].origin, world.frame_covariance(frame)
    deviation = np.sqrt(np.diag(covariance).clip(min=0))
    variances, axes = np.linalg.eigh(covariance[:3, :3])
    is_known = bool(variances[-1] <= UNSEEN**2)
    base_to_base = BaseToBase(
        xyz=origin.xyz if is_known else None,
        rpy=origin.rpy if is_known else None,
        xyz_deviation=as_point(deviation[3:]) if is_known else None,
        turn_deviation=as_point(deviation[:3]) if is_known else None,
        tool_deviation=_tool_deviation(world, robot, frame, shared) if is_known else None,
        shared_sockets=len(shared),
        text="",
    )
    text = _words(names, base_to_base) if is_known else _turned(names, len(shared), axes[:, -1])
    return replace(base_to_base, text=text)


def _tool_deviation(
    world: JointPosterior, robot: int, frame: str, shared: list[int]
) -> float | None:
    """Return the error of the distance vector of two tools that meet, as predicted [m]."""
    pose = world.frames[frame]
    region = world.arms[0].centres[shared] if shared else _recorded_by_both(world, robot, pose)
    first, places = _inside(world, 0, IDENTITY, region)
    second, points_beside = _inside(world, robot, pose, region)
    if not len(first) or not len(second):
        return None
    nearest = np.argmin(np.linalg.norm(places[:, None] - points_beside, axis=2), axis=1)
    arm = world.arms[robot]
    rigid = PoseModel.of(arm.model.robot, arm.model.ball.origins(arm.values))
    limits = arm.model.robot.lower, arm.model.robot.upper
    targets = np.tile(np.eye(4)[:3].ravel(), (len(places), 1))
    targets[:, 3::4] = pose.inverse().apply(places)
    met = PoseSolver(rigid, len(arm.model.robot.joints) - 1, limits, "point").solve(
        targets, second[nearest]
    )
    if not met.reached.any():
        return None
    _, by_first, _ = _linear(world, 0, first[met.reached])
    points, by_second, _ = _linear(world, robot, met.positions[met.reached])
    members, begin = world.own, world.own[-1].stop + 6 * list(world.frames).index(frame)
    slopes = np.zeros((len(points), 3, len(world.covariance)))
    slopes[:, :, members[0]] = -by_first
    slopes[:, :, members[robot]] = pose.rotation @ by_second
    slopes[:, :, begin : begin + 6] = pose.slopes(points)
    squares: np.ndarray = np.sum((slopes @ world.covariance) * slopes, axis=(1, 2))
    return max(float(squares.mean()), 0.0) ** 0.5


def _recorded_by_both(world: JointPosterior, robot: int, pose: Pose) -> np.ndarray:
    """Return corners of the region in the world where both recorded, or between where each did."""
    balls = [
        frame_pose.apply(_linear(world, i, world.scene.arms[i].positions)[0])
        for i, frame_pose in ((0, IDENTITY), (robot, pose))
    ]
    lowest = np.array([np.min(b, axis=0) for b in balls])
    highest = np.array([np.max(b, axis=0) for b in balls])
    return np.array([lowest.max(axis=0), highest.min(axis=0)])


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


def _words(names: tuple[str, str], base: BaseToBase) -> str:
    """Return a known pose for people."""
    (first, second), tools = names, base.tool_deviation
    assert base.xyz and base.rpy and base.xyz_deviation and base.turn_deviation
    offset, turn = 1e3 * max(base.xyz_deviation), np.degrees(max(base.turn_deviation))
    place = " ".join(f"{1e3 * value:+.2f}" for value in base.xyz)
    turned = " ".join(f"{np.degrees(value):+.3f}" for value in base.rpy)
    frames = (
        f"{second}'s base stands at {place} mm (+- {offset:.2f}), turned "
        f"{turned} deg (+- {turn:.2f}) in {first}'s: no better, since "
        "each base frame hangs on its own joint 1 zero, which no ball shows"
    )
    if tools is None:
        return f"{frames}. No place was found that both tools reach."
    return (
        f"Tool to tool, where {second}'s tool stands seen from {first}'s in the shared region, is "
        f"known to {1e3 * tools:.2f} mm (1 sigma), by both calibrated models together. "
        f"{frames[0].upper()}{frames[1:]}."
    )


def _turned(names: tuple[str, str], shared: int, axis: np.ndarray) -> str:
    """Return what is missing where a turn of one robot against the other is left."""
    first, second = names
    along = " ".join(f"{value:+.2f}" for value in axis)
    count = {0: "no socket", 1: "one socket", 2: "two sockets"}.get(
        shared, f"{shared} sockets on one line"
    )
    freedom = "about their line" if shared > 1 else "about it"
    return (
        f"{second} stands nowhere yet seen from {first}: {count} shared leave it free to turn "
        f"{freedom} (along {along} in {first}'s base). Let both record one more placement, "
        "off that line: two placements cure it, three are better."
    )
