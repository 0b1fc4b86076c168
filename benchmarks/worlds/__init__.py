"""Worlds of benchmarks and tests with known truth: realistic arms, instruments, cells of two."""

import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mukca.recorder import Placement, Sample
from mukca.solver.identification.data import Pose
from mukca.solver.identification.effects import COMPLIANCE, EFFECTS, HARMONICS, TILT
from mukca.solver.identification.model import Deflection
from mukca.solver.identification.robot import BallModel, Robot, workspace
from mukca.tools.simulation import Base, Imperfection, record

# Each calibration of a benchmark tells whether its covariances are covariances.
os.environ.setdefault("MUKCA_CHECK_COVARIANCES", "1")

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


def realistic_flaws(robot: Robot, generator: np.random.Generator) -> Imperfection:
    """Return noise, elasticity and transmission error as calibrations of real arms have them."""
    coefficients: list[np.ndarray] = []
    for extension, (low, high) in SIZES.items():
        count = len(EFFECTS[extension].coefficient_names(robot.joint_names))
        if EFFECTS[extension].non_negative:
            coefficients.append(generator.uniform(low, high, count))
        else:
            coefficients.append(
                generator.normal(0, generator.uniform(low, high), count)
            )
    deflection = Deflection(tuple(SIZES), tuple(coefficients))
    return Imperfection(noise=generator.uniform(*NOISE), deflection=deflection)


def measured_points(
    arm: Robot,
    frame: Pose,
    generator: np.random.Generator,
    *,
    samples: int = 60,
    noise: float = 0.0,
) -> Placement:
    """Return points that an instrument at ``frame`` measured with noise [m] of an arm in poses."""
    q = workspace(arm, samples, int(generator.integers(2**31)))
    balls = BallModel(arm, []).points(np.empty(0), q)
    points = frame.inverse().apply(balls) + generator.normal(0, 1, balls.shape) * noise
    rows = zip(q.tolist(), points.tolist(), strict=True)
    recorded = tuple(Sample(tuple(row), 0, point=(x, y, z)) for row, (x, y, z) in rows)
    return Placement("points", recorded, arm.joint_names)


def recorded_by_both(
    arms: Sequence[Robot],
    poses: Sequence[Pose],
    bases: Sequence[Base],
    generator: np.random.Generator,
    *,
    samples: int = 12,
    noise: float = 0.0,
) -> list[list[Placement]]:
    """Return what several arms recorded at the same bases, a list of placements for each arm.

    Arms and bases stand at poses in the world, and placements of one base have one name; there are
    so many samples in each socket, with noise of the ball's seat, per axis [m].
    """
    recorded: list[list[Placement]] = []
    for arm, pose in zip(arms, poses, strict=True):
        centres = pose.inverse().apply(np.array([base.centre for base in bases]))
        seen = [
            replace(base, centre=centre, direction=pose.rotation.T @ base.direction)
            for base, centre in zip(bases, centres, strict=True)
        ]
        recorded.append(
            [record(arm, b, generator, samples=samples, noise=noise) for b in seen]
        )
    return recorded
