"""Zeros of joints, in words: what was found of each, and which the data do not decide."""

import math

import numpy as np

from ....errors import fixed
from ..inference import Posterior

DECIDED = math.radians(0.2)
"""The data decide a zero if its standard deviation is no larger: it is then within 0.4 degrees, by
95 %. On simulated arms with play, whose deviations come true, more would promise too much."""
TELLING = 2.0
"""They decide one of so many deviations, too: less is left of it than there was."""


def is_decided(zero: float, deviation: float) -> bool:
    """Tell whether the data decide a joint's zero, both [rad], enough to be written to the arm."""
    return deviation <= max(DECIDED, abs(zero) / TELLING)


def joint_offsets_in_words(posterior: Posterior) -> str:
    """Return what was found of each joint's zero, and which the data do not decide."""
    names = posterior.model.robot.joint_names
    begin = posterior.model.geometry
    end = begin + len(names)
    zeros = posterior.x[begin:end]
    variances = np.diag(posterior.covariance)[begin:end]
    deviations = np.sqrt(variances)
    words: list[str] = []
    for joint, zero, deviation in zip(names, zeros, deviations, strict=True):
        doubt = "" if is_decided(zero, deviation) else " (not decided)"
        angle = math.degrees(zero)
        interval = f"{fixed(angle, 2, '+')} +- {math.degrees(deviation):.2f} deg"
        words.append(f"{joint} {interval}{doubt}")
    return f"joint offsets: {', '.join(words)}"
