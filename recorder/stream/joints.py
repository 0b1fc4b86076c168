"""The joints of the model, as the recorder needs them, and when an arm counts as still."""

import math
from dataclasses import dataclass

WINDOW = 0.3
"""How long a capture averages, where nothing else is said [s]."""
STILL = 5e-4
"""Largest standard deviation of a joint of an arm that is still, where nothing else is said
[rad], [m] for a prismatic joint."""


@dataclass(frozen=True, slots=True)
class JointLimits:
    """One actuated joint of the model, with its limits, as the recorder needs it."""

    name: str
    lower: float = -math.inf
    """Lower limit [rad], [m] for a prismatic joint; infinite for a continuous one."""
    upper: float = math.inf
    """Upper limit, likewise."""
    prismatic: bool = False

    @property
    def unit(self) -> str:
        """Unit of its position in files."""
        return "m" if self.prismatic else "rad"

    def shown(self, value: float) -> str:
        """Return a position, or a difference of positions, as people read it."""
        return f"{value * 1e3:.1f} mm" if self.prismatic else f"{math.degrees(value):.1f}°"
