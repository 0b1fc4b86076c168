"""Checks of samples while recording: outliers, a wrong model, faults; is the arm worth it?"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...recorder import Sample, read_placement
from ...solver import assessment, diagnostics
from ...solver.data import Load, measure
from ...solver.robot import BallModel, Robot, gravity_moments, load_robot, shipped_robots
from .guidance_process import limit_for

ENOUGH = 5
"""Samples in a socket from which on their usual distance from each other counts."""
FAR, FAR_SHARE = 0.06, 4.0
"""Least distance of an outlier from the others [m], and its ratio to their usual distance."""
BEYOND = 0.3
"""Farther off than this neither base nor ball can be [m]: joints read wrongly, or the model is."""
FIRST_POSES = 3
"""Poses in a socket that show a wrong model."""
WRONG_SCATTER, WRONG_RATIO = 0.06, 4.0
"""By the model of another arm, the ball of one socket scatters by more than this [m], and so many
times as far as by the right one."""
SLACK = 0.05
"""Tolerance of the joints' limits [rad]."""


def gravity_of(robot: Robot, load: Load) -> Callable[[Sequence[float]], Sequence[float]] | None:
    """Return the gravity torque as a function of the joint positions; None without masses."""
    if not robot.bodies:
        return None

    def gravity(position: Sequence[float]) -> Sequence[float]:
        moments = gravity_moments(robot, np.array([position]), load.gravity, load.payload)
        return moments[0, : len(position)].tolist()

    return gravity


def odd_pose(robot: Robot, distance: float, samples: Sequence[Sample]) -> str | None:
    """Return a warning where the last of some poses is an outlier of the nominal model, or None."""
    sockets = np.array([sample.socket for sample in samples])
    if len(sockets) < 2:
        return None
    balls = BallModel(robot, []).points(np.zeros(0), np.array([s.position for s in samples]))
    same = sockets[:-1] == sockets[-1]
    here, there = balls[:-1][same], balls[:-1][~same]
    allowed = FAR if len(here) else FAR + distance
    if len(here) + 1 >= ENOUGH:
        away = np.linalg.norm(here - np.median(here, axis=0), axis=1)
        allowed = max(FAR, FAR_SHARE * float(np.median(away)))
    others = here if len(here) else there
    off = float(np.linalg.norm(balls[-1] - np.median(others, axis=0)))
    if off <= allowed:
        return None
    socket = samples[-1].socket
    if off > BEYOND:
        return f"puts the ball {off:.1f} m away: do the joints read right, and is it this model?"
    return (
        f"puts the ball {1e3 * off:.0f} mm from "
        f"{f'the others of socket {socket}' if len(here) else 'the other socket'}: is it seated, "
        f"and in socket {socket}?"
    )


def wrong_model(robot: Robot, samples: Sequence[Sample]) -> str | None:
    """Return a warning where another shipped robot fits some poses far better than a model."""
    q = np.array([s.position for s in samples if s.socket == samples[-1].socket])
    if len(q) < FIRST_POSES or (own := _scatter(robot, q)) < WRONG_SCATTER:
        return None
    scatters = {other.name: _scatter(other, q) for other in _shipped(len(robot.actuated))}
    best = min(scatters, key=lambda name: scatters[name], default=None)
    if best is None or scatters[best] > own / WRONG_RATIO or best == robot.name:
        return None
    return (
        f"this moves like a {best}: by its model the ball of one socket scatters by "
        f"{1e3 * scatters[best]:.0f} mm, by that of {robot.name} by {1e3 * own:.0f} mm. Is "
        "--robot right?"
    )


def similar_models(robot: Robot, position: Sequence[float]) -> str | None:
    """Return the names of the other shipped robots that reach a configuration, or None."""
    names = [
        other.name
        for other in _shipped(len(robot.actuated))
        if other.name != robot.name
        and all(
            joint.lower - SLACK <= value <= joint.upper + SLACK
            for joint, value in zip(other.actuated, position, strict=True)
        )
    ]
    return " or a ".join(names) or None


@lru_cache(maxsize=8)
def _shipped(joints: int) -> tuple[Robot, ...]:
    robots = [load_robot(name) for name in shipped_robots()]
    return tuple(robot for robot in robots if len(robot.actuated) == joints)


def _scatter(robot: Robot, q: np.ndarray) -> float:
    """Return the ball's mean distance from its mean position over some configurations [m]."""
    points = BallModel(robot, []).points(np.zeros(0), q)
    away: np.ndarray = np.linalg.norm(points - points.mean(axis=0), axis=1)
    return float(away.mean())


FAILED = 1
"""Exit status of a certain fault."""


def worth_calibrating(robot: Robot, folder: Path) -> tuple[str, int]:
    """Return a text on the arm's error in recorded poses, or what is wrong, and exit status."""
    placement = read_placement(folder).for_joints(robot.joint_names)
    if wrong := wrong_model(robot, placement.samples):
        return wrong[0].upper() + wrong[1:], FAILED
    measured = measure(placement, robot, sockets=1)
    known = assessment.repeatability_of(robot, None)
    survey = diagnostics.inspect_all(
        robot,
        [measured],
        zeros=diagnostics.is_coarse(known),
        repeatability=known,
    )
    found = assessment.judge([assessment.checks_row(survey.diagnostics)], survey.hypotheses)
    if found.status == "fail":
        return f"Verdict: {found.title}. {found.text}", found.exit_status
    balls = BallModel(robot, []).points(np.zeros(0), measured.positions)
    away = np.linalg.norm(balls - balls.mean(axis=0), axis=1)
    error, good = float(away.mean()), limit_for(robot)
    verdict = "worth calibrating" if error > good else "as good as a calibration would make it"
    return (
        f"By its model the ball scatters by {1e3 * error:.2f} mm about one point (mean of "
        f"{len(away)} poses, {1e3 * away.max():.2f} mm at most). A calibrated arm of this kind "
        f"keeps within {1e3 * good:.2f} mm: {verdict}. Its size was not looked at; that takes two "
        "sockets.",
        0,
    )
