"""The base of drivers that ask a robot where it is, again and again, at a rate of their own."""

from . import clock
from .driver import DriverError, Reason
from .validation import ValidatingDriver


class PolledDriver(ValidatingDriver):
    """A driver whose robot sends a state only when it is asked for one.

    Args:
        where: What is read, for messages to people.
    """

    def __init__(self, where: str) -> None:
        super().__init__(where)
        self._next_poll = 0.0
        """When to ask again, by :func:`.clock.now` [s]; set by the subclass as it asks."""

    def _await_turn(self, deadline: float) -> None:
        """Wait until it is time to ask again.

        Raises:
            DriverError: SILENT when that is after the deadline.
        """
        asked = clock.now()
        if self._next_poll > deadline:
            clock.sleep(max(0.0, deadline - asked))
            raise DriverError(
                Reason.SILENT, f"no state from {self._where} for {deadline - asked:.3g} s"
            )
        clock.sleep(max(0.0, self._next_poll - asked))
