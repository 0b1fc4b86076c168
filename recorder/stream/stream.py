"""Reader thread of a driver, whom no slow disk or screen holds up."""

import math
from collections import deque

from ...drivers import Driver, DriverError, JointState, Reason, Reconnecting, clock
from .. import StreamLog

BEHIND = 0.5
"""States that wait this much longer than they are needed are left out [s]."""
PATIENCE = 0.1
"""Longest wait for a state before the thread checks for its end [s]."""


class Stream:
    """The states of a driver, which it closes, in order, each with the time at which it arrived.

    Beyond the capacity the oldest is dropped and counted in :attr:`dropped`.
    """

    def __init__(self, driver: Driver, capacity: int = 120_000) -> None:
        self._driver = driver
        self._waiting: deque[tuple[float, JointState, int]] = deque()
        self._capacity = capacity
        self.arrival = -math.inf
        """Time of the newest state [s, monotonic]."""
        self.dropped = 0
        """States that nobody took in time."""
        self.trouble: str | None = None
        """Reason why no states come; None while they come."""
        self.log: StreamLog | None = None
        """Given every state that is taken, and the number of lost connections by then."""
        self.ended = False
        """True once the driver gave up for good; :attr:`trouble` says why."""
        self._stop = clock.repeat(self._step, driver.close)

    @property
    def missed(self) -> int:
        """States that the robot sent and that were lost on the way, or not taken in time."""
        return self._driver.missed + self.dropped

    @property
    def rejected(self) -> int:
        """Messages that the driver discarded."""
        return self._driver.rejected

    @property
    def drops(self) -> int:
        """Number of times that the connection was lost and made again."""
        return self._driver.drops if isinstance(self._driver, Reconnecting) else 0

    @property
    def waiting(self) -> int:
        """Number of states that were not taken yet."""
        return len(self._waiting)

    def take(self, count: int = 1_000_000) -> list[tuple[float, JointState, int]]:
        """Return the oldest states that were not taken yet, at most so many."""
        waiting = self._waiting
        taken = [waiting.popleft() for _ in range(min(count, len(waiting)))]
        if self.log:
            for _, state, connection in taken:
                self.log.add(state, connection)
        return taken

    def catch_up(self, newest: float) -> None:
        """Leave out all but the newest states, of so many seconds, if others wait far too long.

        Whoever is slower than the stream would else look at ever older states. They are logged.
        """
        waiting = self._waiting
        if not waiting or self.arrival - waiting[0][0] < newest + BEHIND:
            return
        while waiting and waiting[0][0] < self.arrival - newest:
            self.take(1)

    def close(self) -> None:
        """End the thread and the connection; safe to call twice."""
        self._stop()

    def _step(self) -> bool:
        """Read one state; return False once no more will come."""
        try:
            state = self._driver.read(PATIENCE)
        except DriverError as error:
            self.trouble = str(error)
            self.ended = error.reason is not Reason.SILENT
        except Exception as error:
            # A plug-in may fail in any way; the session goes on to be saved.
            self.trouble, self.ended = f"the driver failed: {error!r}", True
        else:
            self.trouble = None
            if len(self._waiting) >= self._capacity:
                self._waiting.popleft()
                self.dropped += 1
            self.arrival = clock.now()
            self._waiting.append((self.arrival, state, self.drops))
        return not self.ended
