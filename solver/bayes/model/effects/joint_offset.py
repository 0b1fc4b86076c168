"""Joint offset: an encoder reads too little by a constant, q' = q + z."""

import numpy as np

from .effect import OWN, Effect


def _derivatives(q: np.ndarray, moments: np.ndarray) -> np.ndarray:
    del moments
    return np.ones(q.shape)


JOINT_OFFSET = Effect(
    name="zero",
    extension="",
    unit="rad",
    axes={"zero": OWN},
    derivatives=_derivatives,
    typical_shift=float(np.deg2rad(3)),  # as they are set by eye
    learned=False,
    # what printed parts are off by: the offsets are the larger part of what is wrong with angles
    geometry_widths={"translation": 2e-4, "rotation": 7e-4},
)
