"""How well a stream of joint states runs: its rate, and how evenly its states come."""

from collections import deque
from dataclasses import dataclass

WINDOW_SECONDS = 1.0
LATEST_INTERVALS = 2000


@dataclass(frozen=True)
class Reading:
    """A stream's figures at one moment."""

    rate: float
    """States per second, over the last second."""
    interval: float
    """Median time between two states [s]."""
    worst_interval: float
    """99th percentile of it [s]."""


class Meter:
    """Watches when states arrive."""

    def __init__(self) -> None:
        self._arrivals: deque[float] = deque()
        self._intervals: deque[float] = deque(maxlen=LATEST_INTERVALS)
        self._waited = False

    def add(self, arrival: float, waited: bool) -> None:
        """Note a state.

        Args:
            arrival: When it was there, by the monotonic clock [s].
            waited: Whether it had to be waited for. A state that was there already says nothing
                about when it came, and the next one's interval is not counted either.
        """
        if waited and self._waited:
            self._intervals.append(arrival - self._arrivals[-1])
        self._waited = waited
        self._arrivals.append(arrival)
        while self._arrivals[0] < arrival - WINDOW_SECONDS:
            self._arrivals.popleft()

    def read(self) -> Reading:
        """Return the figures; 0 where nothing is known yet."""
        span = self._arrivals[-1] - self._arrivals[0] if self._arrivals else 0.0
        rate = (len(self._arrivals) - 1) / span if span > 0 else 0.0
        ordered = sorted(self._intervals) or [0.0]
        return Reading(rate, ordered[len(ordered) // 2], ordered[int(0.99 * (len(ordered) - 1))])
