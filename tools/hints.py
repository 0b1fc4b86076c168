"""What the nominal model can tell the operator while recording."""

from collections.abc import Callable, Sequence

import numpy as np

from ..recorder.dataset import Sample
from ..solver.data.observations import Load
from ..solver.robot.kinematics import BallModel, gravity_torques
from ..solver.robot.urdf import Robot

__all__ = ["gravity_of", "seat_check"]

ENOUGH = 5
"""So many samples in a socket before one of them can be called an outlier."""
FAR, FAR_SHARE = 0.025, 4.0
"""An outlier is this far from the others [m], and so many times as far as they usually are."""


def gravity_of(
    robot: Robot, load: Load | None = None
) -> Callable[[Sequence[float]], Sequence[float]] | None:
    """Return the gravity torque as a function of the joint positions; None without masses.

    Args:
        robot: The robot.
        load: What pulls at the joints; None for an upright base and no payload.
    """
    if not robot.bodies:
        return None
    load = load or Load()

    def gravity(position: Sequence[float]) -> Sequence[float]:
        torques = gravity_torques(robot, np.array([position]), load.gravity, load.payload)
        return torques[0].tolist()

    return gravity


def seat_check(robot: Robot) -> Callable[[Sequence[Sample]], str | None]:
    """Return a function that doubts the last of some samples, where the ball was elsewhere.

    By the nominal model the ball's centres of one socket lie within a few millimetres up to some
    20 mm, a ball in the other socket 50 mm away.
    """
    model = BallModel(robot, [])
    points: dict[int, np.ndarray] = {}

    def ball(sample: Sample) -> np.ndarray:
        """Its centre [m], reckoned once for each sample: the stream must not wait."""
        if sample.number not in points:
            points[sample.number] = model.points(np.zeros(0), np.array([sample.position]))[0]
        return points[sample.number]

    def check(samples: Sequence[Sample]) -> str | None:
        last = samples[-1]
        here = np.array([ball(sample) for sample in samples if sample.socket == last.socket])
        if len(here) < ENOUGH:
            return None
        away = np.linalg.norm(here - np.median(here[:-1], axis=0), axis=1)
        if away[-1] <= max(FAR, FAR_SHARE * float(np.median(away[:-1]))):
            return None
        return (
            f"sample {last.number} puts the ball {1e3 * away[-1]:.0f} mm from the others of "
            f"socket {last.socket}: is it seated, and in this socket? d takes the sample back"
        )

    return check
