"""The kinds of numbers that describe an arm, and how large each can be.

Degrees typed for radians, millimetres for metres and grams for kilograms lead to other numbers
without a word. Whoever reads such a number asks its :class:`Quantity` whether it can be.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """A kind of number, its unit, and the unit that is typed by mistake."""

    unit: str
    largest: float
    """Absolute value that none exceeds."""
    mistaken: str

    def doubt(self, values: Iterable[float], largest: float | None = None) -> str | None:
        """Return what is doubtful of the largest number, or None where all of them can be.

        Args:
            values: Numbers in the quantity's unit.
            largest: A narrower range than the quantity's own, as an arm's reach.
        """
        worst = max(values, key=abs, default=0.0)
        if abs(worst) <= (self.largest if largest is None else largest):
            return None
        return f"{worst:.6g}: {self.unit} are expected (are these {self.mistaken}?)"


ROTATION = Quantity("radians", 2 * math.pi + 1e-3, "degrees")
"""Roll, pitch or yaw of a pose, a tool or a link."""
JOINT_POSITION = Quantity("radians", 8 * math.pi, "degrees")
"""Position of a joint that turns."""
ON_FLANGE = Quantity("metres", 5.0, "millimetres")
"""Place of a tool, ball or payload in the flange's frame."""
LENGTH = Quantity("metres", 20.0, "millimetres")
"""Length of a link, or distance of a frame from the arm's base."""
PAYLOAD = Quantity("kilograms", 1000.0, "grams")
"""Mass that an arm carries beyond its model's."""
MASS = Quantity("kilograms", 5000.0, "grams")
"""Mass of all that an arm moves."""
