"""The host's time, and waiting for it to pass: whatever waits does it here.

Call these by the module's name, as in ``clock.now()``: tests put a clock in their place on which
minutes pass in milliseconds.
"""

import select
import time
from collections.abc import Sequence
from typing import Protocol, TypeVar


class _Readable(Protocol):
    def fileno(self) -> int: ...


_Source = TypeVar("_Source", bound="int | _Readable")


def now() -> float:
    """Return the host's monotonic time [s]."""
    return time.monotonic()


def sleep(seconds: float) -> None:
    """Wait."""
    time.sleep(seconds)


def wait(sources: Sequence[_Source], seconds: float) -> list[_Source]:
    """Return the sources that can be read, as soon as one can; none once the time is up.

    Args:
        sources: File descriptors, or objects with one.
        seconds: How long to wait at most [s].

    Raises:
        OSError: A source is closed; so does ValueError.
    """
    return select.select(sources, [], [], seconds)[0]
