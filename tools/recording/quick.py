"""Quick check on ten poses in one socket: is it worth calibrating?"""

from pathlib import Path

import numpy as np

from ...recorder import read_placement
from ...solver.assessment import checks_row, judge, repeatability_of
from ...solver.data import measure
from ...solver.diagnostics import inspect_all, is_coarse
from ...solver.robot import BallModel, Robot
from .guidance_process import limit_for
from .outlier_checks import wrong_model_check

FAILED = 1
"""Exit status of what is surely wrong."""


def worth_calibrating(robot: Robot, folder: Path) -> tuple[str, int]:
    """Return a text on the arm's error in recorded poses, or what is wrong, and exit status."""
    placement = read_placement(folder).for_joints(robot.joint_names)
    if odd := wrong_model_check(robot)(placement.samples):
        return odd[0].upper() + odd[1:], FAILED
    measured = measure(placement, robot, sockets=1)
    known = repeatability_of(robot, None)
    survey = inspect_all(
        robot,
        [measured],
        zeros=is_coarse(known),
        repeatability=known,
    )
    found = judge([checks_row(survey.diagnostics)], causes=survey.hypotheses)
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
