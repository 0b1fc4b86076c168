"""The nominal robot with only the place of its ball fitted, which calibrations are held against."""

from collections.abc import Sequence

import numpy as np

from .. import results
from ..identification import data
from ..identification.data import Measurement, Pose
from ..identification.paper import REGULARIZATION, build_problem, solve
from ..identification.robot import Robot
from .problem import CalibrationProblem


def ball_refitted(problem: CalibrationProblem) -> results.CalibratedRobot | None:
    """Return the nominal robot with only the ball's place fitted; None if it is not identified."""
    robot = problem.robot
    paired = [m for m in problem.measurements if m.has_distance]
    measured = [m for m in problem.measurements if m.kind == "points"]
    ball = results.ball_of(robot)
    if paired:
        regularization = problem.options.regularization or REGULARIZATION
        equations = build_problem(
            robot, paired, parameters=ball, regularization=regularization
        )
        return results.CalibratedRobot(robot, ball, solve(equations).x)
    if measured:
        return results.CalibratedRobot(robot, ball, _ball_by_points(robot, measured))
    return None


def _ball_by_points(robot: Robot, placements: Sequence[Measurement]) -> np.ndarray:
    """Return the ball's place, fitted to measured points together with their frames, shape (3,)."""
    nominal = results.CalibratedRobot(robot)
    by_frame: dict[str, list[Measurement]] = {}
    for m in placements:
        by_frame.setdefault(m.frame, []).append(m)
    frames = [
        data.TipSamples(
            np.concatenate([nominal.predict(m) for m in group]),
            np.concatenate([nominal.rotations(m) for m in group]),
            np.concatenate([m.points for m in group]),
        )
        for group in by_frame.values()
    ]
    origin = Pose.of(robot.ball_joint.origin)
    return origin.apply(data.tip_shift(frames))
