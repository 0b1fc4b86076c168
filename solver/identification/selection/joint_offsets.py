"""Zeros of joints, in words: what was found of each, and which the data do not decide."""

import math

import numpy as np

from ....errors import fixed
from ..inference import Posterior

DECIDED = math.radians(0.2)
"""The data decide a zero if its standard deviation is no larger: it is then within 0.4 degrees, by
95 %. On simulated arms with play, whose deviations come true, more would promise too much."""


def is_decided(zero: float, deviation: float) -> bool:
    """Tell whether the data decide a joint's zero, both [rad], enough to be written to the arm.

    So they do of two deviations or more: less is left of it than there was.
    """
    return deviation <= max(DECIDED, abs(zero) / 2)


def joint_offsets_in_words(posterior: Posterior) -> str:
    """Return what was found of each joint's zero, and which the data do not decide."""
    names = posterior.model.robot.joint_names
    begin = posterior.model.geometry
    zeros = slice(begin, begin + len(names))
    deviations = np.sqrt(np.diag(posterior.covariance)[zeros])
    words = [
        f"{joint} {fixed(math.degrees(zero), 2, '+')} +- {math.degrees(deviation):.2f} deg"
        f"{'' if is_decided(zero, deviation) else ' (not decided)'}"
        for joint, zero, deviation in zip(
            names, posterior.x[zeros], deviations, strict=True
        )
    ]
    return f"joint offsets: {', '.join(words)}"
