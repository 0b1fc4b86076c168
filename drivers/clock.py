"""The host's time, and waiting for it to pass: whatever waits does it here.

Call these by the module's name, as in ``clock.now()``: tests put others in their place.
"""

import select
import selectors
import threading
import time
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

STOP_SECONDS = 1.5
"""A thread that waits for a robot is left alone after so long [s]."""
ALPHA = 0.05
# The usual choice for a given ALPHA (Benedict and Bordner, 1962).
BETA = ALPHA**2 / (2 - ALPHA)
GREATEST_ERROR = (
    0.05  # s: a state that is later than this came after a pause; begin anew
)


class _Readable(Protocol):
    def fileno(self) -> int: ...


_Source = TypeVar("_Source", bound="int | _Readable")


def now() -> float:
    """Return the host's monotonic time [s]."""
    return time.monotonic()


def sleep(seconds: float) -> None:
    """Wait."""
    time.sleep(seconds)


def left(deadline: float) -> float:
    """Return the time from now to a deadline, 0 after it [s]."""
    return max(0.0, deadline - now())


def wait(sources: Sequence[_Source], seconds: float) -> list[_Source]:
    """Return the sources that can be read, as soon as one can; none once the time is up [s].

    Sources are file descriptors, or objects with one. A closed one raises OSError or ValueError.
    """
    try:
        return select.select(sources, [], [], seconds)[0]
    # A closed source, or a descriptor beyond 1023, which select cannot take.
    except ValueError:
        with selectors.DefaultSelector() as selector:
            keys = [
                selector.register(source, selectors.EVENT_READ) for source in sources
            ]
            ready = {key.fd for key, _ in selector.select(seconds)}
        return [s for s, key in zip(sources, keys, strict=True) if key.fd in ready]


def repeat(step: Callable[[], bool], end: Callable[[], None]) -> Callable[[], None]:
    """Call a function again and again in a thread of its own, until it returns False.

    Then ``end`` is called there. What is returned ends the thread, and waits for it for a moment;
    it is safe to call twice. A step should take no longer than a fraction of a second.
    """
    stopped = threading.Event()

    def run() -> None:
        while not stopped.is_set() and step():
            pass
        end()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()

    def stop() -> None:
        stopped.set()
        thread.join(timeout=STOP_SECONDS)

    return stop


class ArrivalTimeFilter:
    """Even stamps for a robot that sends at a steady rate but gives no time of its own.

    USB adapters and kernels pass messages on in bursts: two states that were measured 5 ms apart
    may arrive 0.1 ms apart. This alpha-beta filter tracks a stamp and the period between two.

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
