"""Compliance: a joint twists about its own axis under load, q' = q - c tau."""

from typing import TYPE_CHECKING

from .effect import OWN, Effect

if TYPE_CHECKING:
    import numpy as np

ELASTIC_SHIFT = 5e-4
"""Typical angle by which a joint gives way under its usual load [rad]."""


def _derivatives(q: "np.ndarray", moments: "np.ndarray") -> "np.ndarray":
    return -moments[:, : q.shape[1]]


COMPLIANCE = Effect(
    name="compliance",
    extension="compliance",
    unit="rad/(N m)",
    axes={"compliance": OWN},
    derivatives=_derivatives,
    typical_shift=ELASTIC_SHIFT,
    non_negative=True,
    shared_by_type=True,
)
