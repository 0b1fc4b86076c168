"""Answers on lines that may stall: none is taken for the answer to a later request."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from .. import clock

QUIET = 0.05  # s: all that a line held back has come if nothing more does for so long
LONGEST_DRAIN = 0.5  # s: another program may use the line, so that it is never quiet

Answer = TypeVar("Answer")


class Line(Protocol):
    """A line that can be emptied."""

    def discard(self, wait: float) -> bool:
        """Throw away what has come, or comes within the wait [s]; return whether anything did."""
        ...


class FreshAnswers:
    """Requests on a line whose answers carry no number, one at a time.

    Before each, what waits is thrown away. After one that nobody answered in time, as after another
    program's, an answer may be late by as long as the line stalled. So the first answer then is not
    believed: the line is emptied until it is quiet, and the request is sent again.
    """

    def __init__(self, line: Line) -> None:
        self._line = line
        self._owed = True

    def ask(self, request: Callable[[], Answer], until: float = 0.0) -> Answer:
        """Return the answer to a request, which raises ValueError where none comes in time."""
        while True:
            self._drain(0.0)
            owed, self._owed = self._owed, True
            try:
                answer = request()
            except ValueError:
                if clock.now() >= until:
                    raise
                continue
            self._owed = False
            if not owed:
                return answer
            self._drain(QUIET)

    def _drain(self, quiet: float) -> None:
        end = clock.now() + LONGEST_DRAIN
        while self._line.discard(quiet) and clock.now() < end:
            pass
