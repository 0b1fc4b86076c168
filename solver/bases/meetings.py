"""The pose of one robot's base in another's, and how well two tools meet."""

from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from ...errors import fixed
from ..identification.data import Samples, as_point
from ..identification.inference import Posterior
from ..identification.robot import workspace
from ..poses import PoseModel, PoseSolver, Solutions
from ..results import UNSEEN, BaseToBase
from ..studies import unit
from .ties import TiedRobots

MARGIN = 0.02
"""The shared region reaches this far beyond the places that both robots visited [m]."""
TRIES = 3000
MEETINGS = 150


def base_to_base(world: TiedRobots, robot: int) -> BaseToBase:
    """Return where a robot stands seen from the first one; no numbers where a turn is left."""
    first = world.robots[0]
    second = world.robots[robot]
    names = (first.name, second.name)
    shared = sorted({*first.sockets} & {*second.sockets})
    columns = world.columns_of(second.frame)
    pose = world.around.marginal(columns)
    variances, axes = np.linalg.eigh(pose.covariance[:3, :3])
    if variances[-1] > UNSEEN**2:
        return BaseToBase(
            xyz=None,
            rpy=None,
            xyz_deviation=None,
            turn_deviation=None,
            tool_deviation=None,
            shared_sockets=len(shared),
            text=_turned(names, len(shared), axes[:, -1]),
        )
    origin = world.poses[second.frame].origin
    result = BaseToBase(
        xyz=origin.xyz,
        rpy=origin.rpy,
        xyz_deviation=as_point(pose.deviations[3:]),
        turn_deviation=as_point(pose.deviations[:3]),
        tool_deviation=_tool_deviation(world, robot, shared),
        shared_sockets=len(shared),
        text="",
    )
    return replace(result, text=_words(names, result))


class Meetings(NamedTuple):
    """Configurations of two robots, N each, with their balls at one place or near each other."""

    first: np.ndarray
    """Of the first robot, shape (N, m) [rad]."""
    second: np.ndarray
    """Of the other one, likewise."""
    at_one_place: bool = True
    """False where the balls are only near each other."""


def _tool_deviation(
    world: TiedRobots,
    robot: int,
    shared: list[int],
) -> float | None:
    """Return the error of the distance vector of two tools that meet, as predicted [m].

    It is the root mean square of tr A Sigma A^T over places that both reach. A = [-J_1, R J_2, T]
    are the derivatives of the vector by the unknowns of both robots and by the pose R, t of the
    second, and Sigma is their covariance. Of tools that are only near each other, three times the
    variance of their distance counts: a turn of all that both reach changes the vector, and nothing
    else.
    """
    meetings = _meetings(world, robot, shared)
    if not len(meetings.first):
        return None
    frame = world.robots[robot].frame
    pose = world.poses[frame]
    first = Samples.unloaded(meetings.first)
    second = Samples.unloaded(meetings.second)
    _, J1, _ = world.arms[0].linearise(first)
    points, J2, _ = world.arms[robot].linearise(second)
    offsets = pose.apply(points) - _balls(world, 0, meetings.first)
    A = np.zeros((len(points), 3, len(world.around.mean)))
    for k, slopes in ((0, -J1), (robot, pose.rotation @ J2)):
        begin = world.columns[k].start
        A[:, :, begin : begin + slopes.shape[2]] = slopes
    A[:, :, world.columns_of(frame)] = pose.slopes(points)
    along = np.eye(3) if meetings.at_one_place else 3**0.5 * unit(offsets)[:, None]
    deviations = along @ A @ world.around.root
    return (float(np.sum(deviations**2)) / len(points)) ** 0.5


def _meetings(
    world: TiedRobots,
    robot: int,
    shared: list[int],
) -> Meetings:
    """Return meetings in the region of the shared sockets, or else as recorded where both did."""
    region = world.centres[shared] if shared else _recorded_by_both(world, robot)
    if not shared:
        # an instrument may have seen few postures, which others tell nothing of
        first, second = [
            _inside(world, k, region, world.arms[k].data.q) for k in (0, robot)
        ]
        if len(first.q) and len(second.q):
            return Meetings(first.q, _nearest(first, second), at_one_place=False)
    first, second = [
        _inside(world, k, region, workspace(world.arms[k].model.robot, TRIES, k))
        for k in (0, robot)
    ]
    if not len(first.q) or not len(second.q):
        return Meetings(first.q[:0], second.q[:0])
    pose = world.poses[world.robots[robot].frame]
    targets = pose.inverse().apply(first.places)
    met = _led_to(world.arms[robot], targets, _nearest(first, second))
    return Meetings(
        first=first.q[met.reached],
        second=met.positions[met.reached],
    )


def _led_to(
    arm: Posterior,
    targets: np.ndarray,
    starts: np.ndarray,
) -> Solutions:
    """Return the joint positions of an arm with its ball at targets, shape (N, 3) [m]."""
    robot = arm.model.robot
    rigid = PoseModel.of(robot, arm.model.ball.origins(arm.values))
    limits = (robot.lower, robot.upper)
    solver = PoseSolver(rigid, len(robot.joints) - 1, limits, "point")
    poses = np.tile(np.eye(4)[:3].ravel(), (len(targets), 1))
    poses[:, 3::4] = targets
    return solver.solve(poses, starts)


def _recorded_by_both(world: TiedRobots, robot: int) -> np.ndarray:
    """Return corners of the region in the world where both recorded, or between where each did."""
    balls = [_balls(world, k, world.arms[k].data.q) for k in (0, robot)]
    low = np.max([points.min(axis=0) for points in balls], axis=0)
    high = np.min([points.max(axis=0) for points in balls], axis=0)
    return np.array([low, high])


def _balls(
    world: TiedRobots,
    robot: int,
    q: np.ndarray,
) -> np.ndarray:
    """Return balls of a robot without load in the world, shape (N, 3) [m]."""
    points = world.arms[robot].predict(Samples.unloaded(q))
    base = world.poses[world.robots[robot].frame]
    return base.apply(points)


class Configurations(NamedTuple):
    """Configurations of a robot, and where its balls are."""

    q: np.ndarray
    """Shape (N, m) [rad]."""
    places: np.ndarray
    """In the world, shape (N, 3) [m]."""


def _inside(
    world: TiedRobots,
    robot: int,
    region: np.ndarray,
    q: np.ndarray,
) -> Configurations:
    """Return those of configurations q, shape (N, m), whose ball is in the region."""
    places = _balls(world, robot, q)
    low, high = region.min(axis=0) - MARGIN, region.max(axis=0) + MARGIN
    is_inside = np.all((places > low) & (places < high), axis=1)
    some = np.flatnonzero(is_inside)[:MEETINGS]
    return Configurations(q[some], places[some])


def _nearest(
    first: Configurations,
    second: Configurations,
) -> np.ndarray:
    """Return the second's configuration that is nearest to each of the first, (N, m) [rad]."""
    gaps = np.linalg.norm(first.places[:, None] - second.places, axis=2)
    return second.q[np.argmin(gaps, axis=1)]


def _words(names: tuple[str, str], base: BaseToBase) -> str:
    """Return a known pose for people."""
    first, second = names
    assert base.xyz and base.rpy and base.xyz_deviation and base.turn_deviation
    place = " ".join(fixed(1e3 * value, 2, "+") for value in base.xyz)
    offset = 1e3 * max(base.xyz_deviation)
    angles = " ".join(fixed(np.degrees(value), 3, "+") for value in base.rpy)
    turn = np.degrees(max(base.turn_deviation))
    frames = (
        f"{second}'s base stands at {place} mm (+- {offset:.2f}), turned "
        f"{angles} deg (+- {turn:.2f}) in {first}'s: no better, since "
        "each base frame hangs on its own joint 1 zero, which no ball shows"
    )
    tools = base.tool_deviation
    if tools is None:
        return f"{frames}. No place was found that both tools reach."
    return (
        f"Tool to tool, where {second}'s tool stands seen from {first}'s in the shared region, is "
        f"known to {1e3 * tools:.2f} mm (1 sigma), by both calibrated models together. "
        f"{frames[0].upper()}{frames[1:]}."
    )


def _turned(
    names: tuple[str, str],
    shared: int,
    axis: np.ndarray,
) -> str:
    """Return what is missing where a turn of one robot against the other is left."""
    first, second = names
    along = " ".join(fixed(value, 2, "+") for value in axis)
    counts = ("no socket", "one socket", "two sockets")
    count = counts[shared] if shared < 3 else f"{shared} sockets on one line"
    freedom = "about their line" if shared > 1 else "about it"
    return (
        f"{second} stands nowhere yet seen from {first}: {count} shared leave it free to turn "
        f"{freedom} (along {along} in {first}'s base). Let both record one more placement, "
        "off that line: two placements cure it, three are better."
    )
