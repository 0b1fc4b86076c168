"""Axes of a panel: ranges of values, and which of them carry a number."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

from ....solver.assessment import nice_above


@dataclass(frozen=True)
class Axis:
    """A range of values, linear or logarithmic, and their label."""

    low: float
    high: float
    label: str = ""
    log: bool = False
    ticks: tuple[float, ...] | None = None
    """Values that carry a number; None for round ones."""

    @classmethod
    def around_zero(cls, values: Iterable[float], label: str, smallest: float = 1e-6) -> "Axis":
        """Return an axis as wide on both sides, with some room beside the largest value."""
        half = 1.1 * max(smallest, *map(abs, values))
        return cls(-half, half, label)

    @classmethod
    def logarithmic(cls, values: Iterable[float], label: str, room: float = 1.5) -> "Axis":
        """Return an axis with room beside the values above zero; round 1 where there are none."""
        positive = [value for value in values if value > 1e-6] or [1.0]
        return cls(min(positive) / room, max(positive) * room, label, log=True)

    def fraction(self, value: float) -> float:
        """Return the place of a value, 0 at the low end and 1 at the high end, never outside."""
        low = self.low
        high = self.high
        if self.log:
            value = math.log(max(value, low))
            low = math.log(low)
            high = math.log(high)
        return min(max((value - low) / (high - low), 0.0), 1.0)

    def marks(self) -> list[float]:
        """Return the values that carry a number: at most two digits a decade where logarithmic."""
        marks = self.ticks
        if marks is None and self.log:
            low = math.log10(self.low)
            high = math.log10(self.high)
            powers = range(math.floor(low), math.ceil(high) + 1)
            digits = (1,) if high - low > 2 else (1, 2, 5)
            marks = [digit * 10.0**power for power, digit in product(powers, digits)]
        elif marks is None:
            step = nice_above((self.high - self.low) / 5)
            first = math.ceil(self.low / step - 1e-9)
            last = math.floor(self.high / step + 1e-9)
            return [k * step for k in range(first, last + 1)]
        return [m for m in marks if self.low * (1 - 1e-9) <= m <= self.high * (1 + 1e-9)]
