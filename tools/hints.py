"""What the nominal model can tell the operator while recording."""

from collections.abc import Callable, Sequence

import numpy as np

from ..recorder.dataset import Sample
from ..solver.kinematics import BallModel, gravity_torques
from ..solver.urdf import Chain

__all__ = ["gravity_of", "seat_check"]

ENOUGH = 5
"""So many samples in a socket before one of them can be called an outlier."""
FAR, FAR_SHARE = 0.025, 4.0
"""An outlier is this far from the others [m], and so many times as far as they usually are."""
STILL = 2e-3
"""Joints that move by less than this [rad] do not change the gravity torque."""


def gravity_of(chain: Chain) -> Callable[[Sequence[float]], Sequence[float]] | None:
    """Return the gravity torque as a function of the joint positions; None without masses.

    The robot's base is taken to stand upright.
    """
    if not chain.bodies:
        return None
    known: dict[str, np.ndarray] = {}

    def gravity(position: Sequence[float]) -> Sequence[float]:
        at = np.array([position], dtype=float)
        if "at" not in known or np.max(np.abs(at - known["at"])) > STILL:
            known["at"], known["torque"] = at, gravity_torques(chain, at)[0]
        return known["torque"].tolist()

    return gravity


def seat_check(chain: Chain) -> Callable[[Sequence[Sample]], str | None]:
    """Return a function that doubts the last of some samples, where the ball was elsewhere.

    By the nominal model the ball's centres of one socket lie within a few millimetres up to some
    20 mm, a ball in the other socket 50 mm away.
    """
    model = BallModel(chain, [])

    def check(samples: Sequence[Sample]) -> str | None:
        last = samples[-1]
        here = np.array([s.position for s in samples if s.socket == last.socket])
        if len(here) < ENOUGH:
            return None
        points = model.points(np.zeros(0), here)
        away = np.linalg.norm(points - np.median(points[:-1], axis=0), axis=1)
        if away[-1] <= max(FAR, FAR_SHARE * float(np.median(away[:-1]))):
            return None
        return (
            f"sample {last.number} puts the ball {1e3 * away[-1]:.0f} mm from the others of "
            f"socket {last.socket}: is it seated, and in this socket? d takes the sample back"
        )

    return check
