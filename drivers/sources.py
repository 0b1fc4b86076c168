"""Detector of two sources whose states come in turn, as two publishers of one topic send them."""

import math
from collections import deque

from .driver import JointState

LATEST = 3.0
"""Time within which returns are counted [s]."""
RETURNS = 5
"""So many returns within it are no single faults."""
FAR = 0.05
"""A smaller step to another state and back is noise [rad], [m]."""
NEAR = 0.2
"""A return ends as near to where it began as this share of the step between."""

TWO_SOURCES = "two sources send these joints in turn"


class SourceDetector:
    """Counts the returns of a stream, fed state by state.

    A return is a state that equals the one before the last, which was far from both. No arm moves
    so, but the states of two sources that are merged do.
    """

    def __init__(self) -> None:
        self._before: deque[tuple[float, ...]] = deque(maxlen=2)
        self._returns: deque[float] = deque()

    @property
    def two_sources(self) -> bool:
        """True while the states are of two sources."""
        return len(self._returns) >= RETURNS

    def feed(self, state: JointState) -> None:
        """Take in a state, sound or not."""
        stamps = self._returns
        while stamps and not 0 <= state.stamp - stamps[0] < LATEST:
            stamps.popleft()
        if len(self._before) == 2:
            first, last = self._before
            step = _distance(last, state.position)
            if step > FAR and _distance(first, state.position) < NEAR * step:
                stamps.append(state.stamp)
        self._before.append(state.position)


def _distance(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    """Return the largest difference of two positions without whole turns, or NaN."""
    if a == b:
        return 0.0
    differences = [y - x for x, y in zip(a, b, strict=False)]
    if not all(map(math.isfinite, differences)):
        return math.nan
    return max((abs(math.remainder(d, math.tau)) for d in differences), default=0.0)
