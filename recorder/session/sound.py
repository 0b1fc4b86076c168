"""What the operator hears: one tone captured, two refused, three at the end of a socket."""

import math
from collections.abc import Callable

__all__ = ["CAPTURED", "DONE", "REFUSED", "Sound"]

CAPTURED, REFUSED, DONE = 1, 2, 3
"""How many tones."""
APART = 0.25
"""Time between two tones [s]; terminals merge tones that are closer."""


class Sound:
    """Rings a bell several times, without waiting.

    Args:
        ring: Rings it once.
        on: Whether it is to be heard at all.
    """

    def __init__(self, ring: Callable[[], None], *, on: bool = True) -> None:
        self._ring = ring
        self._on = on
        self._left = 0
        self._next = -math.inf

    def play(self, tones: int) -> None:
        """Begin with some tones, in place of what has not sounded yet."""
        self._left = tones if self._on else 0

    def go_on(self, now: float) -> None:
        """Sound the next tone if it is due at this time [s, monotonic]."""
        if self._left and now >= self._next:
            self._ring()
            self._left -= 1
            self._next = now + APART
