"""All effects, in the order in which they are tried and listed.

To add one:

1. Write ``effects/NAME.py`` with one :class:`Effect`: its name, unit, the axis of a joint that each
   coefficient turns, the derivatives of that turn by the coefficients, and the typical size.
2. Add it to the table below.

Selection, priors, export, report and JSON ask the effect itself. What turns no joint, as a base
that drifts, needs an axis of its own beside those of :mod:`.effect`, and its column in
:meth:`.ExtendedModel.linearise`.
"""

from .backlash import BACKLASH
from .compliance import COMPLIANCE
from .curve import CURVE
from .effect import Effect
from .joint_offset import JOINT_OFFSET
from .tilt import TILT
from .transmission import HARMONICS

EFFECTS: dict[str, Effect] = {
    effect.name: effect for effect in (JOINT_OFFSET, COMPLIANCE, TILT, BACKLASH, *HARMONICS, CURVE)
}
"""Every effect by its name; the first one alone can be held by the geometry."""
EXTENSIONS: dict[str, tuple[str, ...]] = {
    one.extension: tuple(e.name for e in EFFECTS.values() if e.extension == one.extension)
    for one in EFFECTS.values()
    if one.extension
}
"""Extensions in the order in which they are tried, each with its effects."""
