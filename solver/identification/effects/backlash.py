"""Backlash: a joint rests where gravity turns it to, q' = q - p tau / sqrt(tau^2 + tau_0^2)."""

import math
from typing import TYPE_CHECKING

from .effect import OWN, Array, Effect

if TYPE_CHECKING:
    import numpy as np

UNLOADED_TORQUE = 0.02
"""tau_0: under less, the joint may rest on either side [N m]."""
LOADED_VARIANCE = 0.02
"""Share of an unloaded joint's variance that is left under load."""


def _side(torque: Array) -> Array:
    return torque / (torque**2 + UNLOADED_TORQUE**2) ** 0.5


def _joint_noise(torque: Array) -> Array:
    excess = 1 - _side(torque) ** 2 - LOADED_VARIANCE
    return (LOADED_VARIANCE + (excess + abs(excess)) / 2) ** 0.5


def _random(joints: int, generator: "np.random.Generator") -> Array:
    """Return the play of joints that are worn alike, as a share of the largest, shape (joints,)."""
    return generator.uniform(0.5, 1.0, joints)


BACKLASH = Effect(
    name="play",
    extension="play",
    unit="rad",
    axes={"play": OWN},
    derivatives=lambda samples: -_side(samples.torques),
    # of a servo, until the noise of its joints shows it
    typical_shift=math.radians(0.3),
    learned=False,
    joint_noise=_joint_noise,
    random=_random,
    requires="zero",
)
