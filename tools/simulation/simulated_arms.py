"""Simulated arms whose true kinematics are known, with imperfections as real arms have them."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from ...solver.bayes.model import Deflection, extend
from ...solver.bayes.model.effects import COMPLIANCE, EFFECTS, HARMONICS, TILT
from ...solver.robot import STANDARD_GRAVITY, Origin, Robot, choose_parameters

TRANSLATION, TURN = 1e-3, 6e-3
"""Standard deviations of joint origins from the model [m], [rad]."""
SIZES = {
    COMPLIANCE.name: (1e-5, 6e-5),
    TILT.name: (0.0, 3e-5),
    HARMONICS[0].name: (0.7e-4, 2.5e-4),
    HARMONICS[1].name: (0.3e-4, 1.2e-4),
}
"""From, to: each coefficient of elasticity [rad/(N m)]; the standard deviation of an arm's
coefficients of transmission error [rad]."""
NOISE = (5e-5, 1e-4)
"""From, to: standard deviation of the ball's seat, per axis [m]."""


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
    """The smallest step that the encoders tell [rad]."""
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    """In the base frame [m/s^2]."""


def realistic_flaws(robot: Robot, generator: np.random.Generator) -> Imperfection:
    """Return noise, elasticity and transmission error as calibrations of real arms have them."""
    coefficients: list[np.ndarray] = []
    for extension, (low, high) in SIZES.items():
        count = len(EFFECTS[extension].coefficient_names(robot.joint_names))
        if EFFECTS[extension].non_negative:
            coefficients.append(generator.uniform(low, high, count))
        else:
            coefficients.append(generator.normal(0, generator.uniform(low, high), count))
    deflection = Deflection(tuple(SIZES), tuple(coefficients))
    return Imperfection(noise=generator.uniform(*NOISE), deflection=deflection)


def perturb(
    robot: Robot,
    generator: np.random.Generator,
    translation: float,
    angle: float,
    *,
    keep_size: bool = True,
) -> Robot:
    """Return an arm like the nominal one, its actuated joints' and ball's origins a little off.

    ``translation`` is the standard deviation of x, y, z [m], ``angle`` of roll, pitch, yaw [rad].
    Real arms keep the nominal size: links are machined to better than 0.1 %, while such draws
    differ by up to 2 %.
    """
    origins = robot.origins
    for row, joint in zip(origins, robot.joints, strict=True):
        if joint.actuated or joint is robot.ball_joint:
            row[:3] += generator.normal(0, translation, 3)
            row[3:] += generator.normal(0, angle, 3)
    if keep_size:
        larger = _larger_than(robot)
        turning = [joint.actuated for joint in robot.joints]
        for _ in range(4):  # fixed joints keep their lengths, so the others take their part
            origins[turning, :3] *= 1 - larger(origins)
    joints = tuple(
        replace(joint, origin=Origin((x, y, z), (roll, pitch, yaw)))
        for joint, (x, y, z, roll, pitch, yaw) in zip(robot.joints, origins.tolist(), strict=True)
    )
    return replace(robot, joints=joints)


def _larger_than(robot: Robot) -> Callable[[np.ndarray], float]:
    """Return how much larger [1] than a robot one with other origins is, as a fit counts it."""
    parameters = choose_parameters(robot)
    model = extend(robot, parameters)
    by_scale, index = model.by_scale(), [p.index for p in parameters]

    def larger(origins: np.ndarray) -> float:
        return float(by_scale @ (origins.ravel()[index] - model.ball.nominal))

    return larger
