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
    last = {name: EFFECTS.pop(name) for name in [*EFFECTS] if EFFECTS[name] is CURVE}
    EFFECTS.update({effect.name: effect, **last})
    EXTENSIONS.clear()
    for each in EFFECTS.values():
        if each.extension:
            EXTENSIONS[each.extension] = (
                *EXTENSIONS.get(each.extension, ()),
                each.name,
            )


for _effect in (JOINT_OFFSET, GAIN, COMPLIANCE, TILT, BACKLASH, *HARMONICS, CURVE):
    add_effect(_effect)


def effects_of(*, zeros: bool) -> tuple[str, ...]:
    """Return the names of effects that an arm has before any is tried."""
    return tuple(name for name, effect in EFFECTS.items() if zeros and effect.zeros)


def effect_named(name: str) -> Effect | None:
    """Return the effect of a coefficient or a prior's group by its name; None for the geometry."""
    key = name.rpartition(".")[2]
    effects = (
        effect for effect in EFFECTS.values() if key in (effect.name, *effect.axes)
    )
    return next(effects, None)
