"""All effects, in the order in which they are tried and listed."""

from .backlash import BACKLASH
from .curve import CURVE
from .effect import Effect
from .elasticity import COMPLIANCE, TILT
from .gain import GAIN
from .joint_offset import JOINT_OFFSET
from .transmission import HARMONICS

EFFECTS: dict[str, Effect] = {}
"""Every effect by its name; error curves, which have many coefficients, are last."""
EXTENSIONS: dict[str, tuple[str, ...]] = {}
"""Extensions in the order in which they are tried, each with its effects."""


def add_effect(effect: Effect) -> None:
    """Add an effect to the table, before error curves; in this process alone.

    A study adds its own so. An effect of everybody has its line below.
    """
    curve = EFFECTS.pop(CURVE.name, effect)
    EFFECTS[effect.name] = effect
    EFFECTS[curve.name] = curve
    EXTENSIONS.clear()
    for each in EFFECTS.values():
        if each.extension:
            before = EXTENSIONS.get(each.extension, ())
            EXTENSIONS[each.extension] = (*before, each.name)


for _effect in (JOINT_OFFSET, GAIN, COMPLIANCE, TILT, BACKLASH, *HARMONICS, CURVE):
    add_effect(_effect)


def effects_of(*, zeros: bool) -> tuple[str, ...]:
    """Return the names of effects that an arm has before any is tried."""
    if not zeros:
        return ()
    return tuple(name for name, effect in EFFECTS.items() if effect.zeros)


def effect_named(name: str) -> Effect | None:
    """Return the effect of a coefficient or a prior's group by its name; None for the geometry."""
    key = name.rpartition(".")[2]
    effects = (
        effect for effect in EFFECTS.values() if key in (effect.name, *effect.axes)
    )
    return next(effects, None)
