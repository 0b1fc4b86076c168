"""What every part must keep: the error for parameters that cannot, and the common limits."""

import math

from ...errors import MukcaError

TILT = math.radians(60)
"""How far the ball's neck may lean from the vertical, in every direction [rad]."""

BED = 180.0
"""A part fits into a cube of this edge [mm]."""


class PrintableError(MukcaError):
    """A part cannot be made as asked for."""


def check_range(name: str, value: float, low: float, high: float) -> None:
    """Refuse a length out of its range [mm].

    Raises:
        PrintableError: The value lies outside, or is no number.
    """
    if not low <= value <= high:
        raise PrintableError(f"{name} of {value:g} mm: expected {low:g} to {high:g} mm")
