"""Joint offset: an encoder reads too little by a constant, q' = q + z."""

import math

from ..data import Samples
from .effect import OWN, Array, Effect


def _derivatives(samples: Samples) -> Array:
    return 0 * samples.q + 1


JOINT_OFFSET = Effect(
    name="zero",
    extension="",
    unit="rad",
    axes={"zero": OWN},
    derivatives=_derivatives,
    typical_shift=math.radians(3),  # as they are set by eye
    zeros=True,
    of_encoder=True,
    learned=False,
    # what printed parts are off by: the offsets are the larger part of what is wrong with angles
    geometry_widths={"translation": 2e-4, "rotation": 7e-4},
)
