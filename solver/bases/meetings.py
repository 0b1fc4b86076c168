"""Where one robot's base stands seen from another's, and how well two tools meet."""

from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from ..bayes.inference import Posterior
from ..data import SocketSamples, as_point
from ..results import UNSEEN, BaseToBase
from ..robot import PoseModel, PoseSolver, Solutions, workspace
from .ties import TiedRobots

MARGIN = 0.02
"""The shared region reaches this far beyond the places that both robots visited [m]."""
TRIES = 3000
MEETINGS = 150


def base_to_base(world: TiedRobots, robot: int) -> BaseToBase:
    """Return where a robot stands seen from the first one; no numbers where a turn is left."""
    first, second = world.robots[0], world.robots[robot]
    names = (first.name, second.name)
    shared = sorted({*first.sockets} & {*second.sockets})
    pose = world.around.marginal(world.columns_of(second.frame))
    variances, axes = np.linalg.eigh(pose.covariance[:3, :3])
    if variances[-1] > UNSEEN**2:
        text = _turned(names, len(shared), axes[:, -1])
        unknown = dict.fromkeys(
            ("xyz", "rpy", "xyz_deviation", "turn_deviation", "tool_deviation")
        )
        return BaseToBase(**unknown, shared_sockets=len(shared), text=text)
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


def _tool_deviation(world: TiedRobots, robot: int, shared: list[int]) -> float | None:
    """Return the error of the distance vector of two tools that meet, as predicted [m].

    It is the root mean square of tr A Sigma A^T over places that both reach. A = [-J_1, R J_2, T]
    are the derivatives of the vector by the unknowns of both robots and by the pose R, t of the
    second, and Sigma is their covariance.
    """
    region = world.centres[shared] if shared else _recorded_by_both(world, robot)
    first = _inside(world, 0, region)
    second = _inside(world, robot, region)
    if not len(first.q) or not len(second.q):
        return None
    gaps = np.linalg.norm(first.places[:, None] - second.places, axis=2)
    starts = second.q[np.argmin(gaps, axis=1)]
    frame = world.robots[robot].frame
    pose = world.poses[frame]
    met = _led_to(world.arms[robot], pose.inverse().apply(first.places), starts)
    if not met.reached.any():
        return None
    one = _unloaded(first.q[met.reached])
    other = _unloaded(met.positions[met.reached])
    _, J1, _ = world.arms[0].linearise(*one)
    points, J2, _ = world.arms[robot].linearise(*other)
    slopes = np.zeros((len(points), 3, len(world.around.mean)))
    slopes[:, :, world.columns[0]][:, :, : J1.shape[2]] = -J1
    slopes[:, :, world.columns[robot]][:, :, : J2.shape[2]] = pose.rotation @ J2
    slopes[:, :, world.columns_of(frame)] = pose.slopes(points)
    squares: np.ndarray = np.sum((slopes @ world.around.root) ** 2, axis=(1, 2))
    return float(squares.mean()) ** 0.5


def _led_to(arm: Posterior, targets: np.ndarray, starts: np.ndarray) -> Solutions:
    """Return the joint positions of an arm with its ball at targets, shape (N, 3) [m]."""
    robot = arm.model.robot
    rigid = PoseModel.of(robot, arm.model.ball.origins(arm.values))
    solver = PoseSolver(
        rigid, len(robot.joints) - 1, (robot.lower, robot.upper), "point"
    )
    poses = np.tile(np.eye(4)[:3].ravel(), (len(targets), 1))
    poses[:, 3::4] = targets
    return solver.solve(poses, starts)


def _recorded_by_both(world: TiedRobots, robot: int) -> np.ndarray:
    """Return corners of the region in the world where both recorded, or between where each did."""
    balls = [_balls(world, k, world.arms[k].data.positions) for k in (0, robot)]
    lowest = [places.min(axis=0) for places in balls]
    highest = [places.max(axis=0) for places in balls]
    return np.array([np.max(lowest, axis=0), np.min(highest, axis=0)])


def _unloaded(q: np.ndarray) -> SocketSamples:
    """Return configurations without moments."""
    return SocketSamples(q, np.tile(0 * q, 3))


def _balls(world: TiedRobots, robot: int, q: np.ndarray) -> np.ndarray:
    """Return balls of a robot without load in the world, shape (N, 3) [m]."""
    points = world.arms[robot].predict(*_unloaded(q))
    return world.poses[world.robots[robot].frame].apply(points)


class Configurations(NamedTuple):
    """Configurations of a robot, and where its balls are."""

    q: np.ndarray
    """Shape (N, m) [rad]."""
    places: np.ndarray
    """In the world, shape (N, 3) [m]."""


def _inside(world: TiedRobots, robot: int, region: np.ndarray) -> Configurations:
    """Return random configurations whose ball is in the region."""
    q = workspace(world.arms[robot].model.robot, TRIES, robot)
    places = _balls(world, robot, q)
    low = region.min(axis=0) - MARGIN
    high = region.max(axis=0) + MARGIN
    inside = np.all((places > low) & (places < high), axis=1)
    some = np.flatnonzero(inside)[:MEETINGS]
    return Configurations(q[some], places[some])


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
    counts = ("no socket", "one socket", "two sockets")
    count = counts[shared] if shared < 3 else f"{shared} sockets on one line"
    freedom = "about their line" if shared > 1 else "about it"
    return (
        f"{second} stands nowhere yet seen from {first}: {count} shared leave it free to turn "
        f"{freedom} (along {along} in {first}'s base). Let both record one more placement, "
        "off that line: two placements cure it, three are better."
    )
