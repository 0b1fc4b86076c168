"""Elasticity: a joint twists under load, q' = q - c tau (compliance), and tilts.

It bends about the two axes across its own, u = -d M_b and v = -e M_c.
"""

from dataclasses import replace

from ..data import Samples
from .effect import ACROSS_1, ACROSS_2, OWN, Array, Display, Effect

ELASTIC_SHIFT = 5e-4
"""Typical angle by which a joint gives way under its usual load [rad]."""
SHOWN = Display(
    "\N{MICRO SIGN}rad/(N m)",
    1e6,
    usual_turn=10.0,
    usual_words="elasticity under 10 N m",
    heading="elasticity",
)


def _twists(samples: Samples) -> Array:
    return -samples.torques


def _bends(samples: Samples) -> Array:
    return -samples.moments[:, samples.q.shape[1] :]


COMPLIANCE = Effect(
    name="compliance",
    extension="compliance",
    unit="rad/(N m)",
    axes={"compliance": OWN},
    derivatives=_twists,
    typical_shift=ELASTIC_SHIFT,
    shown=replace(SHOWN, by_joint=True),
    non_negative=True,
    elastic=True,
)
TILT = Effect(
    name="tilt",
    extension="tilt",
    unit="rad/(N m)",
    axes={"tilt1": ACROSS_1, "tilt2": ACROSS_2},
    derivatives=_bends,
    typical_shift=ELASTIC_SHIFT,
    shown=SHOWN,
    non_negative=True,
    elastic=True,
)
