"""Limits of the model's joints, and the default window and threshold of stillness."""

import math
from dataclasses import dataclass

WINDOW = 0.3
"""Default length of the average of a capture [s]."""
STILL = 5e-4
"""Default for the largest standard deviation of a joint of an arm that is still [rad], [m] for a
prismatic joint."""


@dataclass(frozen=True, slots=True)
class JointLimits:
    """An actuated joint of the model and its limits."""

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
