"""A clock for simulated arms: time passes as soon as everybody waits, so no computer is too slow.

All runs in one thread. Whoever waits hands over to those who do something again and again, and the
clock jumps to the next moment at which something happens.
"""

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ...drivers import clock

_wait_for_host = clock.wait
_host_time = clock.now
_sleep_by_host = clock.sleep
REPLACED = ("now", "sleep", "wait", "repeat")
"""Functions of the host's clock that a simulated time stands in for."""
BEGIN = 1000.0
"""A host's clock is rarely at zero either [s]."""
LATE = 1e-6
"""Nobody is woken earlier than asked, and by a real clock always somewhat later [s]."""


@dataclass(frozen=True)
class Repeated:
    """A function that is called again and again while others wait."""

    step: Callable[[], bool]
    """Returns False once it is not to be called again."""
    end: Callable[[], None]
    """Called then."""


class SimulatedTime:
    """Stands in for the host's clock, and for the threads that do something again and again.

    Args:
        paced: Never ahead of the host's clock, so that people can watch; it may lag behind.
    """

    def __init__(self, *, paced: bool = False) -> None:
        self._now = BEGIN
        self._paced = paced
        self._began = _host_time()
        self._repeated: list[Repeated] = []
        self._stepping = False

    def now(self) -> float:
        """Return the simulated time [s]."""
        return self._now

    def sleep(self, seconds: float) -> None:
        """Let time pass."""
        self.wait([], seconds)

    def wait(self, sources: Sequence[Any], seconds: float) -> list[Any]:
        """Return the sources that can be read; none once the simulated time is up [s]."""
        end = self._now + seconds
        while True:
            ready = self.ready(sources)
            if ready or self._now >= end:
                return ready
            if self._repeated and not self._stepping:
                self._step()
            else:
                self.pass_until(end)

    def ready(self, sources: Sequence[Any]) -> list[Any]:
        """Return the sources that can be read now."""
        return _wait_for_host(sources, 0.0)

    def pass_until(self, end: float) -> None:
        """Let time pass while nobody does anything [s]."""
        self._now = end + LATE
        if self._paced:
            passed = _host_time() - self._began
            ahead = self._now - BEGIN - passed
            _sleep_by_host(max(0.0, ahead))

    def repeat(
        self, step: Callable[[], bool], end: Callable[[], None]
    ) -> Callable[[], None]:
        """Call a function again and again while others wait; see :func:`.clock.repeat`."""
        repeated = Repeated(step, end)
        self._repeated.append(repeated)
        return lambda: self._end(repeated)

    def _step(self) -> None:
        """Call each repeated function once."""
        self._stepping = True
        for repeated in list(self._repeated):
            if not repeated.step():
                self._end(repeated)
        self._stepping = False

    def _end(self, repeated: Repeated) -> None:
        if repeated in self._repeated:
            self._repeated.remove(repeated)
            repeated.end()

    @contextmanager
    def running(self) -> "Generator[SimulatedTime]":
        """Put it in the place of the host's clock."""
        functions = {name: getattr(clock, name) for name in REPLACED}
        try:
            for name in REPLACED:
                setattr(clock, name, getattr(self, name))
            yield self
        finally:
            for name, function in functions.items():
                setattr(clock, name, function)
