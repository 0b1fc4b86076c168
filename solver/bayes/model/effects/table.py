"""All effects, in the order in which they are tried and listed."""

from .backlash import BACKLASH
from .curve import CURVE
from .effect import Effect
from .elasticity import COMPLIANCE, TILT
from .gain import GAIN
from .joint_offset import JOINT_OFFSET
from .transmission import HARMONICS

EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (JOINT_OFFSET, GAIN, COMPLIANCE, TILT, BACKLASH, *HARMONICS, CURVE)
}
"""Every effect by its name; the first one alone can be held by the geometry."""
EXTENSIONS: dict[str, tuple[str, ...]] = {}
"""Extensions in the order in which they are tried, each with its effects."""
for _effect in EFFECTS.values():
    if _effect.extension:
        EXTENSIONS[_effect.extension] = (*EXTENSIONS.get(_effect.extension, ()), _effect.name)
