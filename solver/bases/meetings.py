"""Where one robot's base stands seen from another's, and how well two tools meet."""

import numpy as np
from msgspec.structs import replace

from ..data import IDENTITY, Pose, as_point
from ..results import UNSEEN, BaseToBase
from ..robot import PoseModel, PoseSolver, workspace
from .ties import TiedRobots

MARGIN = 0.02
"""The shared region reaches this far beyond the places that both robots visited [m]."""
TRIES = 3000
MEETINGS = 150


def base_to_base(world: TiedRobots, robot: int) -> BaseToBase:
    """Return where a robot stands seen from the first one; no numbers where a turn is left."""
    names = (world.robots[0].name, world.robots[robot].name)
    frame = world.robots[robot].frame
    shared = sorted({*world.robots[0].sockets} & {*world.robots[robot].sockets})
    origin = world.poses[frame].origin
    covariance = world.frame_covariance(frame)
    deviation = np.sqrt(np.diag(covariance).clip(min=0))
    variances, axes = np.linalg.eigh(covariance[:3, :3])
    is_known = bool(variances[-1] <= UNSEEN**2)
    result = BaseToBase(
        xyz=origin.xyz if is_known else None,
        rpy=origin.rpy if is_known else None,
        xyz_deviation=as_point(deviation[3:]) if is_known else None,
        turn_deviation=as_point(deviation[:3]) if is_known else None,
        tool_deviation=_tool_deviation(world, robot, shared) if is_known else None,
        shared_sockets=len(shared),
        text="",
    )
    text = _words(names, result) if is_known else _turned(names, len(shared), axes[:, -1])
    return replace(result, text=text)


def _tool_deviation(world: TiedRobots, robot: int, shared: list[int]) -> float | None:
    """Return the error of the distance vector of two tools that meet, as predicted [m]."""
    frame = world.robots[robot].frame
    pose = world.poses[frame]
    region = world.centres[shared] if shared else _recorded_by_both(world, robot)
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
    slopes = np.zeros((len(points), 3, len(world.around.mean)))
    for i, by_unknowns in ((0, -by_first), (robot, pose.rotation @ by_second)):
        begin = world.columns[i].start
        slopes[:, :, begin : begin + by_unknowns.shape[2]] = by_unknowns
    slopes[:, :, world.columns_of(frame)] = pose.slopes(points)
    squares: np.ndarray = np.sum((slopes @ world.around.root) ** 2, axis=(1, 2))
    return float(squares.mean()) ** 0.5


def _recorded_by_both(world: TiedRobots, robot: int) -> np.ndarray:
    """Return corners of the region in the world where both recorded, or between where each did."""
    balls = [
        world.poses[world.robots[i].frame].apply(_linear(world, i, world.arms[i].data.positions)[0])
        for i in (0, robot)
    ]
    lowest = np.array([np.min(b, axis=0) for b in balls])
    highest = np.array([np.max(b, axis=0) for b in balls])
    return np.array([lowest.max(axis=0), highest.min(axis=0)])


def _linear(
    world: TiedRobots, robot: int, q: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    arm = world.arms[robot]
    return arm.model.linearise(arm.x, q, np.tile(0 * q, 3))


def _inside(
    world: TiedRobots, robot: int, pose: Pose, region: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return random configurations whose ball is in the region, and the balls in the world."""
    q = workspace(world.arms[robot].model.robot, TRIES, robot)
    places = pose.apply(world.arms[robot].predict(q, np.tile(0 * q, 3)))
    low = region.min(axis=0) - MARGIN
    high = region.max(axis=0) + MARGIN
    inside = ((places > low) & (places < high)).all(axis=1)
    return q[inside][:MEETINGS], places[inside][:MEETINGS]


def _words(names: tuple[str, str], base: BaseToBase) -> str:
    """Return a known pose for people."""
    first, second = names
    tools = base.tool_deviation
    assert base.xyz and base.rpy and base.xyz_deviation and base.turn_deviation
    offset = 1e3 * max(base.xyz_deviation)
    turn = np.degrees(max(base.turn_deviation))
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
