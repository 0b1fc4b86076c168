"""Lengths as people type them, and readings of one length, which believe each other."""

from collections.abc import Sequence
from itertools import pairwise
from typing import cast

import numpy as np

Readings = float | Sequence[float] | np.ndarray
"""One reading of a length, or several [m]."""
AGREEING = 1.2e-4
"""Two readings of a caliper that are no farther apart are of one length [m]."""
_UNITS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}


def millimetres(text: str) -> float:
    """Return a typed length, such as ``0.1``, ``0.1mm`` or ``100um`` [mm]."""
    return metres(text, 1e-3) / 1e-3


def metres(text: str, unit: float = 1.0) -> float:
    """Return a typed length, such as ``0.1001`` or ``100.1mm`` [m]; ValueError for no length.

    ``unit`` is that of a number without one [m].
    """
    word = text.strip()
    for name, factor in _UNITS.items():
        if word.endswith(name):
            return factor * float(word[: -len(name)])
    return unit * float(word)


def readings_of(distance: Readings | None) -> tuple[float, ...]:
    """Return readings as a tuple; none where nobody read anything."""
    if distance is None:
        return ()
    if isinstance(distance, np.ndarray):
        return tuple(np.ravel(distance).tolist())
    if isinstance(distance, Sequence) and not isinstance(distance, str):
        return tuple(distance)
    return (cast("float", distance),)


def agreed_length(readings: Sequence[float]) -> float:
    """Return the mean of the two readings that are nearest to each other, or the last one [m].

    The last one stands where no two agree.
    """
    pairs = pairwise(sorted(readings))
    a, b = min(pairs, key=lambda pair: pair[1] - pair[0], default=(0.0, 1.0))
    if b - a > AGREEING:
        return readings[-1]
    return round((a + b) / 2, 7)


def agreeing(length: float, readings: Sequence[float]) -> int:
    """Return how many readings agree with a length [m]."""
    return sum(abs(reading - length) <= AGREEING for reading in readings)
