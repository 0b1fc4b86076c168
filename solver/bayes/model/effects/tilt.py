"""Tilt: a joint bends about the two axes across its own, u = -d M_b and v = -e M_c."""

from typing import TYPE_CHECKING

from .compliance import ELASTIC_SHIFT
from .effect import ACROSS_1, ACROSS_2, Effect

if TYPE_CHECKING:
    import numpy as np


def _derivatives(q: "np.ndarray", moments: "np.ndarray") -> "np.ndarray":
    return -moments[:, q.shape[1] :]


TILT = Effect(
    name="tilt",
    extension="tilt",
    unit="rad/(N m)",
    axes={"tilt1": ACROSS_1, "tilt2": ACROSS_2},
    derivatives=_derivatives,
    typical_shift=ELASTIC_SHIFT,
    non_negative=True,
    shared_by_type=True,
)
