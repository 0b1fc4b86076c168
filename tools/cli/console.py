"""Output of the verbs: lines, tables and JSON; with ``--json`` all text goes to standard error."""

import os
import sys
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import (
        Callable,
        Collection,
        Generator,
        Iterable,
        Mapping,
        Sequence,
    )

    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from ...solver.results import Document

PIPED_WIDTH = 120
"""Width of a table that goes to a file or another program, where no line has to be broken."""
SCREEN = (24, 80)
"""Lines and columns of a terminal's screen, into which an answer goes."""


class Terminal:
    """Streams of a command; a ``brief`` one is part of another, and says only its result."""

    def __init__(self, *, json: bool = False, brief: bool = False) -> None:
        self.json = json
        self.brief = brief

    @cached_property
    def console(self) -> "Console":
        """A rich console on the people's stream; plain text where that is no terminal."""
        from rich.console import Console

        console = Console(stderr=self.json, highlight=False, soft_wrap=True)
        if not console.is_terminal and "COLUMNS" not in os.environ:
            console.width = PIPED_WIDTH
        return console

    @contextmanager
    def progress(self, total: int | None = None) -> "Generator[Callable[[str], None]]":
        """Show a progress bar on a terminal; yield a function that takes the name of each step."""
        if not sys.stderr.isatty():
            yield lambda _: None
            return
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task("", total=total)
            yield lambda step: bar.update(task, description=step, advance=1)

    def say(self, *texts: str) -> None:
        """Write lines for people, as they are."""
        sys.stdout.flush()
        stream = sys.stderr if self.json else sys.stdout
        stream.writelines(f"{text}\n" for text in texts)

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
            sys.stdout.flush()

    def tabulate(
        self,
        title: str,
        heads: "Sequence[str]",
        rows: "Iterable[Sequence[str]]",
        **more: Any,
    ) -> None:
        """Print a table for people; see :func:`table`."""
        self.console.print(table(title, heads, rows, **more))

    def warn(self, *texts: str, level: str = "warning") -> None:
        """Write lines about something that may be wrong, or is, to standard error."""
        sys.stderr.writelines(f"{level}: {' '.join(text.split())}\n" for text in texts)

    def emit(self, value: "Mapping[str, Any] | Document") -> None:
        """Write one JSON object on one line, if JSON is asked for; a NaN is a ValueError."""
        if self.json:
            from ...solver.results import encode

            sys.stdout.write(encode(value).decode() + "\n")
            sys.stdout.flush()


def table(
    title: str,
    heads: "Sequence[str]",
    rows: "Iterable[Sequence[str | Text]]",
    *,
    left_columns: "Collection[int]" = (0,),
    bold: "Collection[int]" = (),
    no_wrap: bool = False,
) -> "Table":
    """Table with columns of words to the left, folded where narrow, and of figures to the right.

    The rows named in ``bold`` sum up others; ``no_wrap`` keeps figures on one line.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    drawn = Table(
        box=SIMPLE_HEAD, title=Text(title) if title else None, title_justify="left",
        padding=(0, 1, 0, 0),
    )  # fmt: skip
    for column, head in enumerate(heads):
        if column in left_columns:
            drawn.add_column(
                Text(head), overflow="fold", min_width=16 if no_wrap else None
            )
        else:
            drawn.add_column(Text(head), justify="right", no_wrap=no_wrap)
    for number, cells in enumerate(rows):
        texts = [cell if isinstance(cell, Text) else Text(cell) for cell in cells]
        drawn.add_row(*texts, style="bold" if number in bold else None)
    return drawn
