"""Checks of samples while recording: outliers, a wrong model, faults; is the arm worth it?"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import combinations
from pathlib import Path

import numpy as np

from ...recorder import read_placement
from ...solver import assessment, diagnostics
from ...solver.identification.data import Load, measure
from ...solver.identification.robot import (
    Robot,
    gravity_moments,
    load_robot,
    nominal_balls,
    shipped_robots,
)
from .pose_pool import Captures, positions_in

ENOUGH = 5
"""Samples in a socket from which on their usual distance from each other counts."""
FAR, FAR_SHARE = 0.06, 4.0
"""Least distance of an outlier from the others [m], and its ratio to their usual distance."""
BEYOND = 0.3
"""Farther off than this neither base nor ball can be [m]: joints read wrongly, or the model is."""
GROSS = 0.5
"""Share of a distance beyond which it was typed in another unit."""
FIRST_POSES = 3
"""Poses in a socket that show a wrong model."""
WRONG_SCATTER, WRONG_RATIO = 0.06, 4.0
"""By the model of another arm, the ball of one socket scatters by more than this [m], and so many
times as far as by the right one."""
FLIPS = 2
"""So many joints at most are tried with the other sign."""
SIGN_RATIO = 2.5
"""With the right signs, or zero, the ball of one socket scatters so many times less."""
TURNS = np.deg2rad(np.arange(-179, 181))
"""Angles by which a joint may read otherwise [rad]."""
SLACK = 0.05
"""Tolerance of the joints' limits [rad]."""


def gravity_of(
    robot: Robot, load: Load
) -> Callable[[Sequence[float]], Sequence[float]] | None:
    """Return the gravity torque as a function of the joint positions; None without masses."""

    def gravity(position: Sequence[float]) -> Sequence[float]:
        q = np.array([position])
        moments = gravity_moments(robot, q, load.gravity, load.payload)
        return moments[0, : len(position)].tolist()

    return gravity if robot.bodies else None


def odd_pose(robot: Robot, distance: float, samples: Captures) -> str | None:
    """Return a warning where the last of some poses is an outlier of the nominal model, or None."""
    if len(samples) < 2:
        return None
    sockets = np.array([sample.socket for sample in samples])
    *balls, ball = nominal_balls(robot, np.array([s.position for s in samples]))
    in_socket = np.array(balls)[sockets[:-1] == sockets[-1]]
    is_first = not len(in_socket)
    references = np.array(balls) if is_first else in_socket
    allowed = FAR + distance if is_first else FAR
    centre = np.median(references, axis=0)
    if len(in_socket) + 1 >= ENOUGH:
        distances = np.linalg.norm(in_socket - centre, axis=1)
        allowed = max(FAR, FAR_SHARE * float(np.median(distances)))
    gap = float(np.linalg.norm(ball - centre))
    if gap <= allowed:
        return None
    if gap > BEYOND:
        return f"puts the ball {gap:.1f} m away: do the joints read right, and is it this model?"
    socket = samples[-1].socket
    others = "the other socket" if is_first else f"the others of socket {socket}"
    return (
        f"puts the ball {1e3 * gap:.0f} mm from {others}: "
        f"is it seated, and in socket {socket}?"
    )


def wrong_model(robot: Robot, samples: Captures) -> str | None:
    """Return a warning where another shipped robot fits some poses far better than a model."""
    q = positions_in(samples, samples[-1].socket)
    if len(q) < FIRST_POSES or (scatter := _scatter(robot, q)) < WRONG_SCATTER:
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
    """Return the same of the configurations of one socket, shape (N, m)."""
    scatter = _scatter(robot, q)
    if scatter < WRONG_SCATTER:
        return None
    names = robot.joint_names
    for count in range(1, FLIPS + 1):
        scatters: dict[tuple[int, ...], float] = {}
        for flipped in combinations(range(len(names)), count):
            signs = np.ones(len(names))
            signs[list(flipped)] = -1
            scatters[flipped] = _scatter(robot, signs * q)
        best = min(scatters, key=scatters.__getitem__)
        if scatters[best] < min(scatter / SIGN_RATIO, _turned(robot, q)[0]):
            joints = " and ".join(names[joint] for joint in best)
            return (
                f"sign of {joints}: with the other, the ball of one socket scatters by "
                f"{1e3 * scatters[best]:.0f} mm, not {1e3 * scatter:.0f}"
            )
    return None


def wrong_zero(robot: Robot, samples: Captures) -> str | None:
    """Return a warning where another zero of one joint makes the ball scatter far less, or None."""
    for socket in sorted({s.socket for s in samples}):
        q = positions_in(samples, socket)
        if len(q) < FIRST_POSES or (scatter := _scatter(robot, q)) < WRONG_SCATTER:
            continue
        turned, joint = _turned(robot, q)
        ratio = WRONG_RATIO if len(q) < ENOUGH else SIGN_RATIO
        if turned < scatter / ratio:
            return (
                f"zero of {joint}: with another, the ball of one socket scatters by "
                f"{1e3 * turned:.0f} mm, not {1e3 * scatter:.0f}"
            )
    return None


def wrong_joint(robot: Robot, samples: Captures) -> tuple[int, str] | None:
    """Return the place of the first sample that a joint reads far otherwise, and the joint.

    None where no joint does. The last balls are far from their sockets, as the samples before them
    locate these, and near with another reading of one joint. The first joint is left out, since a
    base that turned looks the same.
    """
    q = np.array([sample.position for sample in samples])
    sockets = np.array([sample.socket for sample in samples])
    for first in range(FIRST_POSES, len(q) - 1):
        before, since = nominal_balls(robot, q[:first]), nominal_balls(robot, q[first:])
        seats = [before[sockets[:first] == socket] for socket in sockets[first:]]
        if min(map(len, seats)) < FIRST_POSES:
            continue
        centres = np.array([np.median(seat, axis=0) for seat in seats])
        usual = [
            np.median(np.linalg.norm(seat - centre, axis=1))
            for seat, centre in zip(seats, centres, strict=True)
        ]
        gaps = np.linalg.norm(since - centres, axis=1)
        if gaps.min() > FAR > max(usual):
            turned, joint = _turned(robot, q[first:], centres)
            return (first, joint) if turned < gaps.mean() / WRONG_RATIO else None
    return None


def _turned(
    robot: Robot, q: np.ndarray, points: np.ndarray | None = None
) -> tuple[float, str]:
    """Return the least mean distance of balls from points with another reading of a joint [m].

    It comes with the joint. The points, shape (N, 3) [m], are the mean of the balls by default.
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


def wrong_distance(robot: Robot, distance: float, samples: Captures) -> float | None:
    """Return the distance of the sockets by the nominal model if the given one is grossly off [m].

    None where it is not. By as little as an arm of servos may be off, it is not grossly off.
    """
    sockets = np.array([s.socket for s in samples])
    balls = nominal_balls(robot, np.array([s.position for s in samples]))
    if not {0, 1} <= set(sockets.tolist()):
        return None
    centres = np.array([np.median(balls[sockets == k], axis=0) for k in (0, 1)])
    likely = float(np.linalg.norm(centres[1] - centres[0]))
    scatter = np.linalg.norm(balls - centres[sockets.clip(0, 1)], axis=1).mean()
    allowed = max(BEYOND, FAR_SHARE * scatter, GROSS * likely)
    return likely if abs(likely - distance) > allowed else None


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


def _distances(robot: Robot, q: np.ndarray) -> np.ndarray:
    """Return the ball's distances from its mean position over some configurations [m]."""
    balls = nominal_balls(robot, q)
    return np.asarray(np.linalg.norm(balls - balls.mean(axis=0), axis=1))


def _scatter(robot: Robot, q: np.ndarray) -> float:
    """Return their mean [m]."""
    return float(_distances(robot, q).mean())


FAILED = 1
"""Exit status of a certain fault."""


def worth_calibrating(robot: Robot, folder: Path) -> tuple[str, int]:
    """Return a text on the arm's error in recorded poses, or what is wrong, and exit status."""
    placement = read_placement(folder).for_joints(robot.joint_names)
    if complaint := wrong_model(robot, placement.samples):
        return complaint[0].upper() + complaint[1:], FAILED
    measured = measure(placement, robot, sockets=1)
    repeats = assessment.repeatability_of(robot, None)
    zeros = diagnostics.is_coarse(repeats)
    survey = diagnostics.inspect_all(
        robot, [measured], zeros=zeros, repeatability=repeats
    )
    rows = [assessment.checks_row(survey.diagnostics)]
    judgement = assessment.judge(rows, survey.hypotheses)
    if judgement.status == "fail":
        return f"Verdict: {judgement.title}. {judgement.text}", judgement.exit_status
    distances = _distances(robot, measured.positions)
    error = float(distances.mean())
    limit = limit_for(robot)
    verdict = "as good as a calibration would make it"
    if error > limit:
        verdict = "worth calibrating"
    return (
        f"By its model the ball scatters by {1e3 * error:.2f} mm about one point (mean of "
        f"{len(distances)} poses, {1e3 * distances.max():.2f} mm at most). "
        f"A calibrated arm of this kind keeps within {1e3 * limit:.2f} mm: {verdict}. "
        "Its size was not looked at; that takes two sockets.",
        0,
    )


GOAL = 3.0
"""Ratio of the limit on held-out errors to the arm's repeatability."""


def goal_for(robot: Robot) -> float:
    """Return the goal of the predicted error of distances [m], before anything is solved."""
    return diagnostics.predicted_limit(limit_for(robot))


def limit_for(robot: Robot) -> float:
    """Return the limit on held-out errors [m]: three times the arm's repeatability.

    At least as many times the resolution of a printed socket.
    """
    name = assessment.known_arm(robot)
    resolution = assessment.RESOLUTION
    return GOAL * max(
        assessment.ARMS[name].repeatability if name else resolution, resolution
    )
