"""Flaws of the size that real arms have, drawn at random: what studies of the methods simulate.

The sizes are those that calibrations of real arms with harmonic drives come out with.
"""

from collections.abc import Sequence

import numpy as np

from ...solver.bayes.model import Deflection
from ...solver.bayes.model.effects import COMPLIANCE, EFFECTS, HARMONICS, TILT
from ...solver.robot import Robot
from .simulated_arms import Imperfection

__all__ = ["TRANSLATION", "TURN", "realistic_flaws"]

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


def realistic_flaws(
    robot: Robot, generator: np.random.Generator, extensions: Sequence[str] = tuple(SIZES)
) -> Imperfection:
    """Return noise, elasticity and transmission error like a real arm's.

    Args:
        robot: The arm.
        generator: Source of randomness.
        extensions: Which of them it has.
    """
    coefficients: list[np.ndarray] = []
    for extension in extensions:
        low, high = SIZES[extension]
        count = len(EFFECTS[extension].coefficient_names(robot.joint_names))
        if EFFECTS[extension].non_negative:
            coefficients.append(generator.uniform(low, high, count))
        else:
            coefficients.append(generator.normal(0, generator.uniform(low, high), count))
    deflection = Deflection(tuple(extensions), tuple(coefficients))
    return Imperfection(noise=generator.uniform(*NOISE), deflection=deflection)
