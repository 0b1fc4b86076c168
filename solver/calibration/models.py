"""The models that a calibration is compared with: nominal, ball fitted anew, exported URDF."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..data import Measurement, Pose, fit_frames, fit_pose
from ..paper import ball_only, build_problem, solve
from ..results import CalibratedRobot
from ..robot import BallModel, Robot, all_parameters
from .fit import Predict

BALL_STEPS = 6
"""Gauss-Newton steps for the ball's place alone; the problem is nearly linear."""


def models_of(calibrated: CalibratedRobot) -> dict[str, Predict]:
    """Return the models to compare: name, and how each predicts the balls of a placement.

    Nominal, calibrated, and the exported geometry where it differs.
    """
    models: dict[str, Predict] = {
        "nominal": lambda m: calibrated.nominal_ball(m.positions),
        "calibrated": lambda m: calibrated.ball(m.positions, m.efforts),
    }
    if calibrated.exported is not None:
        models["geometric"] = lambda m: calibrated.geometric_ball(m.positions)
    return models


def ball_refitted(
    robot: Robot, train: Sequence[Measurement], regularization: float
) -> dict[str, Predict]:
    """Return the nominal model with only the ball's place fitted; nothing where none tells it."""
    paired = [measured for measured in train if measured.has_distance]
    measured = [m for m in train if m.kind == "points"]
    if not paired and measured:
        return {"ball_refitted": _ball_by_points(robot, measured)}
    if not paired:
        return {}
    problem = ball_only(build_problem(robot, paired, regularization=regularization))
    x = solve(problem).x
    return {"ball_refitted": lambda m: problem.model.points(x, m.positions)}


def _ball_by_points(robot: Robot, train: Sequence[Measurement]) -> Predict:
    """Return the nominal model with the ball's place fitted to measured points.

    Gauss-Newton for the ball's place and for the pose of each frame, which follows from the place.
    """
    free = [p.index for p in all_parameters(robot) if p.of_ball and p.unit == "m"]
    model = BallModel(robot, free)
    x = model.nominal.copy()
    by_frame: dict[str, list[Measurement]] = {}
    for m in train:
        by_frame.setdefault(m.frame, []).append(m)
    for _ in range(BALL_STEPS):
        rows: list[np.ndarray] = []
        off: list[np.ndarray] = []
        for group in by_frame.values():
            linear = model.linearise(x, np.concatenate([m.positions for m in group]))
            measured = np.concatenate([m.points for m in group])
            pose = fit_pose(measured, linear.points)
            slopes = pose.slopes(measured).reshape(-1, 6)
            by_ball = linear.by_parameters.reshape(-1, len(free))
            rows.append(by_ball - slopes @ np.linalg.lstsq(slopes, by_ball, rcond=None)[0])
            off.append((linear.points - pose.apply(measured)).ravel())
        x -= np.linalg.lstsq(np.concatenate(rows), np.concatenate(off), rcond=None)[0]
    return lambda m: model.points(x, m.positions)


def frames_of(
    models: Mapping[str, Predict], train: Sequence[Measurement]
) -> dict[str, dict[str, Pose]]:
    """Return where each model has the frames in which points trained on were measured."""
    measured = [m for m in train if m.kind == "points"]
    return {name: fit_frames([(p(m), m) for m in measured]) for name, p in models.items()}
