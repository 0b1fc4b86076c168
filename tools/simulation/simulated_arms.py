"""Simulated arms whose true kinematics are known, with imperfections as real arms have them."""

from dataclasses import dataclass, field

import numpy as np

from ...solver.bayes.model import Deflection, extend
from ...solver.bayes.model.effects import JOINT_OFFSET
from ...solver.robot import STANDARD_GRAVITY, Robot, choose_parameters


@dataclass(frozen=True)
class Imperfection:
    """Imperfections of an arm and of its recording."""

    noise: float = 0.0
    """Standard deviation of the ball's seat, per axis [m]."""
    deflection: Deflection = field(default_factory=Deflection)
    """Elasticity and transmission error."""
    play: float = 0.0
    """Full play of each joint [rad], which rests on the side that gravity turns it to."""
    resolution: float = 0.0
    """Of the encoders [rad]; 0 for none."""
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    """In the base frame [m/s^2]."""


def perturb(
    robot: Robot,
    generator: np.random.Generator,
    translation: float,
    angle: float,
    *,
    keep_size: bool = True,
    zeros: bool = False,
) -> Robot:
    """Return an arm like the nominal one, its actuated joints' and ball's origins a little off.

    ``translation`` is the standard deviation of x, y, z [m], ``angle`` of roll, pitch, yaw [rad].
    Real arms keep the nominal size: links are machined to better than 0.1 %, while such draws
    differ by up to 2 %. With ``zeros``, as of servos, that is the size beside the joints' zeros.
    """
    origins = robot.origins
    for row, joint in zip(origins, robot.joints, strict=True):
        if joint.actuated or joint is robot.ball_joint:
            row[:3] += generator.normal(0, translation, 3)
            row[3:] += generator.normal(0, angle, 3)
    if keep_size:
        parameters = choose_parameters(robot)
        model = extend(robot, parameters, [JOINT_OFFSET.name] if zeros else [])
        by_scale, index = model.by_scale()[: len(parameters)], [p.index for p in parameters]
        turning = [joint.actuated for joint in robot.joints]
        for _ in range(4):  # fixed joints keep their lengths, so the others take their part
            larger = float(by_scale @ (origins.ravel()[index] - model.ball.nominal))
            origins[turning, :3] *= 1 - larger
    return robot.with_origins(origins)
