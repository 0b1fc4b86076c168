"""Stamps for a robot that sends evenly and gives no time of its own.

Adapters and kernels hand messages on in bursts, so that the time of arrival is a poor stamp: two
states that were measured 5 ms apart may come 0.1 ms apart. An alpha-beta filter on the arrivals
gives even stamps back::

    predicted = stamp + period                 error  = arrival - predicted
    stamp     = predicted + ALPHA error        period = period + BETA error
"""

__all__ = ["EvenStamps"]

ALPHA = 0.05
BETA = ALPHA**2 / (2 - ALPHA)  # critically damped (Benedict and Bordner)
GREATEST_ERROR = 0.05  # s: beyond it the stream was interrupted, and the filter begins anew


class EvenStamps:
    """Turns times of arrival into stamps.

    Args:
        period: How far apart the states are, about [s]; it is learned from the arrivals.
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._last: float | None = None

    def __call__(self, arrival: float) -> float:
        """Return the stamp of the state that arrived at a time [s]; it is after all before."""
        if self._last is None:
            self._last = arrival
            return arrival
        predicted = self._last + self._period
        error = arrival - predicted
        if abs(error) > GREATEST_ERROR:
            self._last = max(arrival, predicted)
            return self._last
        self._period = max(self._period + BETA * error, 1e-6)
        self._last = max(predicted + ALPHA * error, self._last + 0.1 * self._period)
        return self._last
