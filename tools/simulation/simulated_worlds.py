"""Simulated instruments and cells of two arms, whose truth is known."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...recorder import Placement, Sample
from ...solver.data import Pose
from ...solver.robot import BallModel, Robot, workspace
from .recordings import Base, record


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
        recorded.append([record(arm, b, generator, samples=samples, noise=noise) for b in seen])
    return recorded
