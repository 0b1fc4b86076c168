"""Even stamps for a robot that sends at a steady rate but gives no time of its own.

USB adapters and kernels pass messages on in bursts: two states that were measured 5 ms apart may
arrive 0.1 ms apart.
"""

ALPHA = 0.05
BETA = ALPHA**2 / (2 - ALPHA)  # the usual choice for a given ALPHA (Benedict and Bordner, 1962)
GREATEST_ERROR = 0.05  # s: a state that is later than this came after a pause; begin anew


class ArrivalTimeFilter:
    """Alpha-beta filter of arrival times, which tracks a stamp and the period between two.

    For each state, from the stamp before (all in s)::

        predicted = stamp + period               when the state should arrive
        error     = arrival - predicted          how much later it did
        stamp     = predicted + ALPHA * error
        period    = period + BETA * error

    Args:
        period: Roughly the time between two states [s]; the true one is learned.
    """

    def __init__(self, period: float) -> None:
        self.period = period
        """Time between two states, as learned so far [s]."""
        self._last: float | None = None

    def __call__(self, arrival: float) -> float:
        """Return the stamp of the next state [s], later than all before, by its arrival [s]."""
        if self._last is None:
            self._last = arrival
            return arrival
        predicted = self._last + self.period
        error = arrival - predicted
        if abs(error) > GREATEST_ERROR:
            self._last = max(arrival, predicted)
            return self._last
        self.period = max(self.period + BETA * error, 1e-6)
        self._last = max(predicted + ALPHA * error, self._last + 0.1 * self.period)
        return self._last
