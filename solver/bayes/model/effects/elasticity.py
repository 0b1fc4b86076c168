"""Elasticity: a joint twists under load, q' = q - c tau (compliance), and tilts.

It bends about the two axes across its own, u = -d M_b and v = -e M_c.
"""

from typing import TYPE_CHECKING

from .effect import ACROSS_1, ACROSS_2, OWN, Effect

if TYPE_CHECKING:
    import numpy as np

ELASTIC_SHIFT = 5e-4
"""Typical angle by which a joint gives way under its usual load [rad]."""


def _twists(q: "np.ndarray", moments: "np.ndarray") -> "np.ndarray":
    return -moments[:, : q.shape[1]]


def _bends(q: "np.ndarray", moments: "np.ndarray") -> "np.ndarray":
    return -moments[:, q.shape[1] :]


COMPLIANCE = Effect(
    name="compliance",
    extension="compliance",
    unit="rad/(N m)",
    axes={"compliance": OWN},
    derivatives=_twists,
    typical_shift=ELASTIC_SHIFT,
    non_negative=True,
    shared_by_type=True,
)
TILT = Effect(
    name="tilt",
    extension="tilt",
    unit="rad/(N m)",
    axes={"tilt1": ACROSS_1, "tilt2": ACROSS_2},
    derivatives=_bends,
    typical_shift=ELASTIC_SHIFT,
    non_negative=True,
    shared_by_type=True,
)
