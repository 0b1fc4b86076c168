"""Gain: an encoder reads too little by a share, as by a wrong gear ratio, q' = q + g q."""

from ..data import Samples
from .effect import OWN, Array, Effect


def _derivatives(samples: Samples) -> Array:
    return 1.0 * samples.q


GAIN = Effect(
    name="gain",
    extension="",
    unit="1",
    axes={"gain": OWN},
    derivatives=_derivatives,
    typical_shift=0.02,  # of a joint whose ratio is wrong
    of_encoder=True,
    rare=True,
)
