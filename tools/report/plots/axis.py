"""Axes of a panel: ranges of values, and which of them carry a number."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

from ....solver.assessment import nice_above

MM = 1e3
"""Factor of an axis of lengths [m] that shows millimetres."""


@dataclass(frozen=True)
class Axis:
    """A range of values, linear or logarithmic, and their label."""

    low: float
    high: float
    label: str = ""
    factor: float = 1.0
    """Number that is shown of the value 1."""
    log: bool = False
    ticks: tuple[float, ...] | None = None
    """Values that carry a number; None for round numbers."""

    @classmethod
    def around_zero(
        cls,
        values: Iterable[float | None],
        label: str,
        factor: float = 1.0,
        smallest: float = 1e-9,
    ) -> "Axis":
        """Return an axis as wide on both sides, with some room beside the largest value."""
        half = 1.1 * max(smallest, *(abs(value or 0.0) for value in values))
        return cls(-half, half, label, factor)

    @classmethod
    def from_zero(
        cls,
        values: Iterable[float | None],
        label: str,
        factor: float,
        room: float = 1.05,
    ) -> "Axis":
        """Return an axis from zero, with some room beyond the largest value."""
        largest = max(1e-9, *(value or 0.0 for value in values))
        return cls(0, room * largest, label, factor)

    @classmethod
    def logarithmic(
        cls,
        values: Iterable[float | None],
        label: str,
        factor: float = 1.0,
        room: float = 1.5,
    ) -> "Axis":
        """Return an axis with room beside the values above zero; round 1 where there are none."""
        positive = [value for value in values if value and value > 1e-9]
        low, high = min(positive, default=1 / factor), max(positive, default=1 / factor)
        return cls(
            low / room,
            high * room,
            label,
            factor,
            log=True,
        )

    def holds(self, value: float) -> bool:
        """Tell whether a value is within the range."""
        return self.low <= value <= self.high

    def fraction(self, value: float) -> float:
        """Return the place of a value, 0 at the low end and 1 at the high end, never outside."""
        low = self.low
        high = self.high
        if self.log:
            value = math.log(max(value, low))
            low = math.log(low)
            high = math.log(high)
        return min(max((value - low) / (high - low), 0.0), 1.0)

    def number(self, value: float) -> str:
        """Return a value as it is shown."""
        return f"{self.factor * value:.6g}".replace("-", "\N{MINUS SIGN}")

    def marks(self) -> list[float]:
        """Return the values that carry a number: at most two digits a decade where logarithmic."""
        if self.ticks is not None:
            return list(self.ticks)
        low = self.factor * self.low
        high = self.factor * self.high
        if self.log:
            first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
            digits = (1,) if high > 100 * low else (1, 2, 5)
            pairs = product(range(first, last + 1), digits)
            round_numbers = [digit * 10.0**decade for decade, digit in pairs]
            more = 1 + 1e-9
            numbers = [n for n in round_numbers if low <= n * more and n <= high * more]
        else:
            step = nice_above((high - low) / 5)
            first = math.ceil(low / step - 1e-9)
            last = math.floor(high / step + 1e-9)
            numbers = [count * step for count in range(first, last + 1)]
        return [number / self.factor for number in numbers]
