"""Readings that fit another arm, other signs or another zero of a joint, by the nominal model."""

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np

from ...solver.identification.robot import (
    Robot,
    load_robot,
    nominal_balls,
    shipped_robots,
)
from .pose_pool import Captures, positions_in

ENOUGH = 5
"""Samples in a socket from which on their usual distance from each other counts."""
FAR = 0.06
"""By wrong readings, balls of one socket are at least so far apart [m]."""
FIRST_POSES = 3
"""Poses in a socket that show a wrong model."""
WRONG_RATIO = 4.0
"""By the model of another arm, the ball of one socket scatters so many times as far."""
FLIPS = 2
"""So many joints at most are tried with the other sign."""
SIGN_RATIO = 2.5
"""With the right signs, or zero, the ball of one socket scatters so many times less."""
TURNS = np.deg2rad(np.arange(-179, 181))
"""Angles by which a joint may read otherwise [rad]."""
SLACK = 0.05
"""Tolerance of the joints' limits [rad]."""


def wrong_model(robot: Robot, samples: Captures) -> str | None:
    """Return a warning where another shipped robot fits some poses far better than a model."""
    q = positions_in(samples, samples[-1].socket)
    if len(q) < FIRST_POSES or (scatter := _scatter(robot, q)) < FAR:
        return None
    models = _shipped(len(robot.actuated))
    scatters = {model.name: _scatter(model, q) for model in models}
    best = min(scatters, key=scatters.__getitem__, default=None)
    if best is None or scatters[best] > scatter / WRONG_RATIO or best == robot.name:
        return None
    if _turned(robot, q)[0] < scatters[best]:
        return None
    return (
        f"this moves like a {best}: by its model the ball of one socket scatters by "
        f"{1e3 * scatters[best]:.0f} mm, by that of {robot.name} by {1e3 * scatter:.0f} mm. Is "
        "--robot right?"
    )


def wrong_signs(robot: Robot, samples: Captures) -> str | None:
    """Return a warning where a ball stays in its socket with other signs of some joints, or None.

    The fewest joints are named whose readings, turned round, make it scatter far less.
    """
    for socket in sorted({s.socket for s in samples}):
        q = positions_in(samples, socket)
        if len(q) >= ENOUGH and (complaint := _wrong_signs(robot, q)):
            return complaint
    return None


def _wrong_signs(robot: Robot, q: np.ndarray) -> str | None:
    """Return the warning for the configurations of one socket, shape (N, m) [rad], [m]."""
    scatter = _scatter(robot, q)
    if scatter < FAR:
        return None
    names = robot.joint_names
    allowed = min(scatter / SIGN_RATIO, _turned(robot, q)[0])
    for count in range(1, FLIPS + 1):
        scatters: dict[tuple[int, ...], float] = {}
        for flipped in combinations(range(len(names)), count):
            signs = np.ones(len(names))
            signs[list(flipped)] = -1
            scatters[flipped] = _scatter(robot, signs * q)
        best = min(scatters, key=scatters.__getitem__)
        if scatters[best] < allowed:
            joints = " and ".join(names[joint] for joint in best)
            return (
                f"turn the sign of {joints}: then the ball of one socket scatters by "
                f"{1e3 * scatters[best]:.0f} mm, not {1e3 * scatter:.0f}"
            )
    return None


def wrong_zero(robot: Robot, samples: Captures) -> str | None:
    """Return a warning where the ball scatters far less with another zero of one joint, or None.

    It must do so in each socket. Else the joint read well for a time.
    """
    complaint = None
    for socket in sorted({s.socket for s in samples}):
        q = positions_in(samples, socket)
        if len(q) < FIRST_POSES:
            continue
        if (scatter := _scatter(robot, q)) < FAR:
            return None
        turned, joint = _turned(robot, q)
        ratio = WRONG_RATIO if len(q) < ENOUGH else SIGN_RATIO
        if scatter < ratio * turned:
            return None
        complaint = (
            f"{joint} has another zero: with that, the ball of one socket scatters by "
            f"{1e3 * turned:.0f} mm, not {1e3 * scatter:.0f}"
        )
    return complaint


def wrong_joint(robot: Robot, samples: Captures) -> tuple[int, str] | None:
    """Return the index of the first sample in which a joint reads far otherwise, and its name.

    Return None if no joint does. From that sample on, all balls are far from where the samples
    before put their sockets, and near with another reading of the joint. The first joint is left
    out, since a base that turned looks the same.
    """
    if len(samples) < FIRST_POSES:
        return None
    q = np.array([sample.position for sample in samples])
    sockets = np.array([sample.socket for sample in samples])
    balls = nominal_balls(robot, q)
    for first in range(FIRST_POSES, len(q) - 1):
        before = sockets[:first]
        seats = [balls[:first][before == socket] for socket in sockets[first:]]
        if min(map(len, seats)) < FIRST_POSES:
            continue
        centres = np.array([np.median(seat, axis=0) for seat in seats])
        usual = [
            np.median(np.linalg.norm(seat - centre, axis=1))
            for seat, centre in zip(seats, centres, strict=True)
        ]
        gaps = np.linalg.norm(balls[first:] - centres, axis=1)
        if gaps.min() > max(FAR, WRONG_RATIO * max(usual)):
            turned, joint = _turned(robot, q[first:], centres)
            return (first, joint) if turned < gaps.mean() / WRONG_RATIO else None
    return None


def _turned(
    robot: Robot, q: np.ndarray, points: np.ndarray | None = None
) -> tuple[float, str]:
    """Return how near balls come to points with another reading of one joint [m], and its name.

    Args:
        robot: Its first joint is left out.
        q: Configurations, shape (N, m) [rad], [m].
        points: One for each ball, shape (N, 3) [m]; by default the mean of the balls.

    Returns:
        The mean distance, the least over all joints and angles.
    """
    best = np.inf, ""
    for joint in range(1, len(robot.actuated)):
        if robot.actuated[joint].type == "prismatic":
            continue
        turned = np.repeat(q[None], len(TURNS), axis=0)
        turned[..., joint] += TURNS[:, None]
        balls = nominal_balls(robot, turned.reshape(-1, q.shape[1]))
        balls = balls.reshape(len(TURNS), len(q), 3)
        about = balls.mean(axis=1, keepdims=True) if points is None else points
        means = np.linalg.norm(balls - about, axis=2).mean(axis=1)
        best = min(best, (float(means.min()), robot.joint_names[joint]))
    return best


def similar_models(robot: Robot, position: Sequence[float]) -> str | None:
    """Return the names of the other shipped robots that reach a configuration, or None."""
    q = np.array(position)
    models = _shipped(len(robot.actuated))
    names = [
        model.name for model in models if model.name != robot.name and _allows(model, q)
    ]
    return " or a ".join(names) or None


def _allows(robot: Robot, q: np.ndarray) -> bool:
    """Return whether a configuration is within a robot's limits."""
    return bool(((robot.lower - SLACK <= q) & (q <= robot.upper + SLACK)).all())


@lru_cache(maxsize=8)
def _shipped(joints: int) -> tuple[Robot, ...]:
    robots = [load_robot(name) for name in shipped_robots()]
    return tuple(robot for robot in robots if len(robot.actuated) == joints)


def distances_to_mean(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Return the ball's distances from its mean position over some configurations [m]."""
    balls = nominal_balls(robot, q)
    return np.asarray(np.linalg.norm(balls - balls.mean(axis=0), axis=1))


def _scatter(robot: Robot, q: np.ndarray) -> float:
    """Return the mean of the ball's distances from its mean position [m]."""
    return float(distances_to_mean(robot, q).mean())
