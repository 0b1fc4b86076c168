"""``mukca stream``: a robot's live joint angles, to check a connection before recording."""

import logging
import math
import sys
import textwrap
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import chain
from typing import TYPE_CHECKING, Any

from ....drivers import (
    TWO_SOURCES,
    DriverError,
    JointState,
    Reason,
    Reconnecting,
    SourceDetector,
    clock,
    open_driver,
)
from ....errors import fixed
from .. import FittingTable, Options, Terminal

if TYPE_CHECKING:
    from rich.console import Group

WINDOW_SECONDS = 1.0
LATEST_INTERVALS = 2000
READ_SECONDS = 0.5
WAITED_SECONDS = 5e-5  # a read that took less found its state waiting
SCREEN_SECONDS = 0.1
LINE_SECONDS = 1.0
COUNTS = ("missed", "rejected", "drops", "status")


class _StreamOptions(Options):
    driver: str
    count: int | None = None
    seconds: float | None = None
    json: bool = False


def run_stream(options: _StreamOptions, terminal: Terminal) -> int:
    """Show states until the end that was asked for, or Ctrl-C."""
    logging.getLogger("mukca").addHandler(logging.NullHandler())  # drops are told here
    name, _, address = options.driver.partition(":")
    with closing(Reconnecting(lambda: open_driver(name, address))) as driver:
        monitor = _Monitor(driver, options.count, options.seconds)
        if options.json:
            monitor.write_json(terminal)
        elif not sys.stdout.isatty():
            monitor.show(lambda: terminal.say(monitor.line()), LINE_SECONDS)
        else:
            from rich.live import Live

            console = terminal.console
            with Live(console=console, auto_refresh=False, transient=False) as live:
                draw = lambda: live.update(monitor.view(console.width), refresh=True)  # noqa: E731
                monitor.show(draw, SCREEN_SECONDS)
    return 0


class _Monitor:
    """Reader of states, up to a count or a time [s], where one is given."""

    def __init__(
        self, driver: Reconnecting, count: int | None, seconds: float | None
    ) -> None:
        self._driver = driver
        self._left = math.inf if count is None else count
        self._end = math.inf if seconds is None else clock.now() + seconds
        self._arrivals: deque[float] = deque()
        self._intervals: deque[float] = deque(maxlen=LATEST_INTERVALS)
        self._waited = False
        self._sources = SourceDetector()
        self._state: JointState | None = None
        self._arrival = clock.now()

    def write_json(self, terminal: Terminal) -> None:
        last: str | None = None
        for state in self._states():
            trouble = self._driver.trouble or self._doubt
            if trouble != last:
                last = trouble
                terminal.warn(last or "states come again")
            if state:
                terminal.emit(self._as_json(state))

    def show(self, draw: Callable[[], None], seconds: float) -> None:
        """Read to the end; draw the figures every so many seconds, and once more at the end."""
        due = clock.now() + seconds
        for _ in self._states():
            if clock.now() >= due:
                draw()
                due = clock.now() + seconds
        draw()

    def _states(self) -> Iterator[JointState | None]:
        """Yield states to the end; None where none came soon."""
        while self._left > 0 and clock.now() < self._end:
            asked = clock.now()
            try:
                self._state = self._driver.read(READ_SECONDS)
            except DriverError as error:
                if error.reason is not Reason.SILENT:
                    raise
                yield None
                continue
            self._count(asked, clock.now())
            self._sources.feed(self._state)
            yield self._state

    def _count(self, asked: float, arrival: float) -> None:
        # A state that was not waited for was there already: it says nothing about when it came,
        # and the next one's interval is not counted either.
        waited = arrival - asked > WAITED_SECONDS
        if waited and self._waited:
            self._intervals.append(arrival - self._arrival)
        self._waited = waited
        self._arrival = arrival
        self._arrivals.append(arrival)
        while self._arrivals[0] < arrival - WINDOW_SECONDS:
            self._arrivals.popleft()
        self._left -= 1

    def _as_json(self, state: JointState) -> dict[str, Any]:
        return {
            "stamp": state.stamp,
            "position": [_finite(angle) for angle in state.position],
            "effort": state.effort and [_finite(effort) for effort in state.effort],
            **{key: getattr(self._driver, key) for key in COUNTS},
        }

    def line(self) -> str:
        position = self._state.position if self._state else ()
        angles = " ".join(f"{fixed(math.degrees(angle), 3):>9}" for angle in position)
        return f"{angles} deg  {'; '.join(self._figures())}"

    def _figures(self) -> list[str]:
        """Return rate, gaps and losses, the robot's status, and the reason if no state comes."""
        span = self._arrivals[-1] - self._arrivals[0] if self._arrivals else 0.0
        age = clock.now() - self._arrival
        rate = (len(self._arrivals) - 1) / span if span > 0 and age < 1 else 0.0
        ordered = sorted(self._intervals) or [0.0]
        interval = 1e3 * ordered[int(0.5 * (len(ordered) - 1))]
        worst = 1e3 * ordered[int(0.99 * (len(ordered) - 1))]
        figures = (
            f"{rate:.0f} Hz, every {interval:.2f} ms (99 %: {worst:.2f}), "
            f"missed {self._driver.missed}, rejected {self._driver.rejected}, "
            f"drops {self._driver.drops}"
        )
        trouble = self._driver.trouble or f"silent for {age:.1f} s" * (age > 1)
        parts = (figures, self._driver.status, trouble or self._doubt)
        return list(filter(None, parts))

    @property
    def _doubt(self) -> str | None:
        return TWO_SOURCES if self._sources.two_sources else None

    def view(self, width: int) -> "Group":
        """Return the table, and below it all of the figures, however long and narrow."""
        from rich.console import Group
        from rich.text import Text

        rows: list[list[str]] = []
        for index, name in enumerate(self._driver.joint_names):
            cells = [""] * 3
            if state := self._state:
                angle = state.position[index]
                effort = fixed(state.effort[index], 2) if state.effort else ""
                cells = [fixed(math.degrees(angle), 3), fixed(angle, 5), effort]
            rows.append([name, *(f"{cell:>10}" for cell in cells)])
        lines = (textwrap.wrap(part, width) for part in self._figures())
        table = FittingTable("", ("joint", "deg", "rad", "N m"), rows)
        return Group(table, *map(Text, chain.from_iterable(lines)))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
