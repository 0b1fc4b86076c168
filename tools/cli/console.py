"""Output of the verbs: lines, tables and JSON; with ``--json`` all text goes to standard error.

All that the program writes to a terminal is written here, and cleaned; JSON is ASCII.
"""

import os
import sys
import threading
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, count
from typing import TYPE_CHECKING, Any, TextIO

from ...errors import cleaned
from .tables import FittingTable, in_words, wrapped

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Sequence

    from rich.console import Console

    from ...solver.results import Document

PIPED_WIDTH = 120
"""Width of a table that goes to a file or another program, where no line has to be broken."""
SILENCE = 30.0
"""Time between lines of long work [s]."""
SCREEN = (24, 80)
"""Lines and columns of a terminal's screen, into which an answer goes."""


@dataclass(kw_only=True)
class Terminal:
    """Streams of a command; a ``brief`` one is part of another, and says only its result."""

    json: bool = False
    brief: bool = False
    quiet: bool = False
    verbose: bool = False
    heading: str = ""
    """Said above the first line, as the name of one of several arms."""
    kept: list[Any] | None = None
    """Results that are kept here, and not written."""
    step: str = ""
    """The step that long work is at, as the end of a sentence."""
    has_bar: bool = False
    """True while a progress bar says how far it is."""

    @cached_property
    def console(self) -> "Console":
        """A rich console on the people's stream; plain text where that is no terminal."""
        self._say_heading()
        console = _clean_console(stderr=self.json, quiet=self.quiet)
        console.soft_wrap = not console.is_terminal
        if not console.is_terminal and "COLUMNS" not in os.environ:
            console.width = PIPED_WIDTH
        return console

    @contextmanager
    def at_work(self, work: str) -> "Generator[None]":
        """Write a line every :data:`SILENCE` seconds, with the step that work is at.

        A progress bar takes its place, and a quiet terminal has none.
        """
        over = threading.Event()

        def tell() -> None:
            seconds = 0.0
            while not over.wait(SILENCE):
                seconds += SILENCE
                if not self.has_bar:
                    write_error(f"{work}: at work for {seconds:.0f} s{self.step}")

        if not self.quiet:
            threading.Thread(target=tell, daemon=True).start()
        try:
            yield
        finally:
            over.set()

    @contextmanager
    def progress(self, total: int | None = None) -> "Generator[Callable[[str], None]]":
        """Show a progress bar on a terminal; yield a function that takes the name of each step.

        Elsewhere the lines of :meth:`at_work` name the step; a verbose terminal writes each.
        """
        if self.quiet or self.verbose or not sys.stderr.isatty():
            yield self._steps(total)
            return
        from rich.markup import escape
        from rich.progress import Progress

        self.has_bar = True
        with Progress(console=_clean_console(stderr=True), transient=True) as bar:
            task = bar.add_task("", total=total)
            yield lambda step: bar.update(task, description=escape(step), advance=1)
        self.has_bar = False

    def _steps(self, total: int | None) -> "Callable[[str], None]":
        """Return a function that takes the name of each step."""
        numbers = count(1)
        of_all = f" of {total}" if total else ""

        def tell(step: str) -> None:
            line = f"step {next(numbers)}{of_all}: {step}"
            self.step = f", at {line}"
            if self.verbose and not self.quiet:
                write_error(line)

        return tell

    def say(self, *texts: str) -> None:
        """Write lines for people, broken between words where a terminal is narrower."""
        if texts and not self.quiet:
            self._say_heading()
            _write(sys.stderr if self.json else sys.stdout, texts)

    def _say_heading(self) -> None:
        heading, self.heading = self.heading, ""
        if heading:
            self.say(heading)

    def say_rows(
        self,
        rows: "Sequence[Sequence[str]]",
        line_of: "Callable[[Sequence[str]], str]",
    ) -> None:
        """Write rows as lines, or in words where a terminal is narrower; the heads come first.

        A row of a single cell is a remark.
        """
        lines = [line_of(row) if len(row) > 1 else row[0] for row in rows]
        columns = _columns(sys.stderr if self.json else sys.stdout)
        if columns and max(map(len, lines)) > columns:
            heads, *others = rows
            lines = [heads[0], *(in_words(heads, row) for row in others)]
        self.say(*lines)

    def say_in_short(self, *texts: str, below: int) -> None:
        """Write the first lines, so that some ``below`` fit on the same screen, and what is left.

        The first line is written in any case.
        """
        lines, columns = SCREEN
        room = lines - below - 1
        for number, text in enumerate(texts):
            room -= -(-len(text) // columns)
            if room < 0 and number:
                self.say(
                    f"--details shows all figures, and from here {len(texts) - number} more."
                )
                return
            self.say(text)
        self.say("--details shows all figures.")

    def say_at_once(self, text: str) -> None:
        """Write a line on a terminal before work that takes a moment."""
        if sys.stdout.isatty():
            self.say(text)

    def tabulate(
        self,
        title: str,
        heads: "Sequence[str]",
        rows: "Sequence[Sequence[str]]",
        **more: Any,
    ) -> None:
        """Print a table for people; see :class:`FittingTable`."""
        self.console.print(FittingTable(title, heads, rows, **more))

    def warn(self, *texts: str, level: str = "warning") -> None:
        """Write lines about something that may be wrong, or is, to standard error."""
        if texts:
            self._say_heading()
        _write(sys.stderr, [f"{level}: {' '.join(text.split())}" for text in texts])

    def emit(self, value: "dict[str, Any] | Document") -> None:
        """Write one JSON object on one line, if JSON is asked for; a NaN is a ValueError."""
        if self.kept is not None:
            self.kept.append(value if isinstance(value, dict) else value.as_dict())
        elif self.json:
            from ...solver.results import encode

            sys.stdout.write(encode(value).decode() + "\n")


def _clean_console(*, stderr: bool, quiet: bool = False) -> "Console":
    """Return a rich console to which no text of a file gives a command.

    Text is cleaned; styles, and what moves the cursor, are those of mukca.
    """
    from rich.console import Console
    from rich.segment import Segment

    class CleanConsole(Console):
        def render(self, renderable: Any, options: Any = None) -> "Iterable[Segment]":
            for text, style, control in super().render(renderable, options):
                yield Segment(text if control else cleaned(text), style, control)

    return CleanConsole(stderr=stderr, quiet=quiet, highlight=False)


def write_error(line: str) -> None:
    """Write a line to standard error, whole."""
    sys.stderr.write(f"{cleaned(line)}\n")


def _columns(stream: TextIO) -> int | None:
    """Return the width of a terminal; None where a stream goes elsewhere."""
    if not stream.isatty():
        return None
    return os.get_terminal_size(stream.fileno()).columns or SCREEN[1]


def _write(stream: TextIO, texts: "Iterable[str]") -> None:
    """Write lines, on a terminal broken between words."""
    columns = _columns(stream)
    lines = map(cleaned, texts)
    if columns:
        lines = chain.from_iterable(wrapped(line, columns) for line in lines)
    # At once, so that a stream that is flushed after each line is flushed once.
    stream.write("".join(f"{line}\n" for line in lines))
