"""Checks of samples while recording: outliers, a wrong distance; is the arm worth it?"""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ...recorder import read_placement
from ...solver import assessment, diagnostics
from ...solver.identification.data import Load, measure
from ...solver.identification.robot import Robot, gravity_moments, nominal_balls
from .pose_pool import Captures
from .wrong_readings import ENOUGH, FAR, distances_to_mean, wrong_model

FAR_SHARE = 4.0
"""Ratio of the distance of an outlier from the others to their usual distance."""
BEYOND = 0.3
"""Farther off than this neither base nor ball can be [m]: joints read wrongly, or the model is."""
GROSS = 0.5
"""Share of a distance beyond which it was typed in another unit."""


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
    distances = distances_to_mean(robot, measured.positions)
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
